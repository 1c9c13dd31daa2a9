"""Named arrays in an ``.npz`` file, which may come from an untrusted source.

Reading unpickles nothing and checks all sizes before it allocates memory. A damaged or hostile file
raises ``RecordError``. The files are ordinary files of ``numpy.savez_compressed``.
"""

from __future__ import annotations

import math
import struct
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.errors import RecordError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.reading import open_file
from warehouse_core.wording import listed

MAX_BYTES = 64 * 1024 * 1024
"""Limit on the total uncompressed size of the arrays, for both writing and reading."""

Arrays = dict[str, NDArray[Any]]
Schema = Mapping[str, tuple[str, int]]
"""Name of each array, its dtype with byte order, and its number of dimensions."""

_END_RECORD = struct.Struct("<4s4H2LH")
_ZIP64_LOCATOR_SIZE = 20
_MAX_ENTRY_SIZE = 256
"""Limit on the bytes of an array's directory entry: 46 bytes, its name, and some reserve."""


def write_arrays(path: str | Path, arrays: Arrays, schema: Schema) -> None:
    """Write arrays to ``path``, atomically.

    Raises:
        RecordError: the arrays take more than ``MAX_BYTES``.
        OSError: the file cannot be written.

    Example:
        >>> import numpy as np
        >>> from warehouse_core.files import write_arrays
        >>> write_arrays("costs.npz", {"costs": np.array([1.0, 2.5])}, {"costs": ("<f8", 1)})
    """
    size = sum(array.nbytes for array in arrays.values())
    if size > MAX_BYTES:
        raise RecordError(f"{path}: {size} bytes are more than MAX_BYTES = {MAX_BYTES}")
    typed = {name: np.asarray(arrays[name], dtype=dtype) for name, (dtype, _) in schema.items()}
    with atomic_path(path) as part, part.open("wb") as file:
        np.savez_compressed(file, **typed)  # type: ignore[arg-type]


def read_arrays(path: str | Path, *schemas: Schema) -> Arrays:
    """Return the arrays in a file, read-only, whose names and types must match a schema.

    Args:
        path: file to read.
        schemas: allowed schemas, each with different names.

    Raises:
        RecordError: the file is damaged or fits none of the schemas.
        OSError: the file cannot be opened.

    Example:
        >>> import numpy as np
        >>> from warehouse_core.files import read_arrays, write_arrays
        >>> schema = {"costs": ("<f8", 1)}
        >>> write_arrays("costs.npz", {"costs": np.array([1.0, 2.5])}, schema)
        >>> read_arrays("costs.npz", schema)
        {'costs': array([1. , 2.5])}
    """
    with open_file(path) as file:
        try:
            count = _check_directory(file, sorted({len(schema) for schema in schemas}))
            with zipfile.ZipFile(file) as archive:
                return _read_all(archive, [each for each in schemas if len(each) == count])
        except RecordError as error:
            raise RecordError(f"{path}: {error}") from error
        except (ValueError, EOFError, OSError, struct.error, zipfile.BadZipFile, zlib.error,
                RuntimeError, NotImplementedError) as error:  # fmt: skip
            raise RecordError(f"{path}: damaged: {error}") from error


def _check_directory(file: IO[bytes], counts: Sequence[int]) -> int:
    """Return the number of entries in the directory, checked before zipfile reads the directory.

    Raises:
        RecordError: the file has no directory, or its number of entries is not one of ``counts``.
    """
    file.seek(0, 2)
    size = file.tell()
    tail_size = min(size, _END_RECORD.size + _ZIP64_LOCATOR_SIZE)
    file.seek(size - tail_size)
    tail = file.read(tail_size)
    if not tail or tail_size < _END_RECORD.size:
        raise RecordError("not an .npz file")
    signature, _, _, _, entries, directory_size, *_ = _END_RECORD.unpack(tail[-_END_RECORD.size :])
    if signature != b"PK\x05\x06" or tail.startswith(b"PK\x06\x07"):
        raise RecordError("not an .npz file")
    if entries not in counts:
        raise RecordError(f"{entries} arrays; there must be {listed(counts, 'or')}")
    # zipfile reads all entries that fit into the directory, whatever number the file states.
    if directory_size > entries * _MAX_ENTRY_SIZE:
        raise RecordError(f"its directory of {directory_size} bytes is too large")
    return int(entries)


def _read_all(archive: zipfile.ZipFile, schemas: Sequence[Schema]) -> Arrays:
    entries = {entry.filename: entry for entry in archive.infolist()}
    names = sorted(entry.filename for entry in archive.infolist())
    for schema in schemas:
        if names == sorted(f"{name}.npy" for name in schema):
            break
    else:
        raise RecordError(f"arrays are {names}; there must be {sorted(schemas[0])}")
    if sum(entry.file_size for entry in entries.values()) > MAX_BYTES:
        raise RecordError(f"its arrays take more than MAX_BYTES = {MAX_BYTES}")
    return {
        name: _read_one(archive, entries[f"{name}.npy"], name, dtype, dimensions)
        for name, (dtype, dimensions) in schema.items()
    }


def _read_one(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, name: str, dtype: str, dimensions: int
) -> NDArray[Any]:
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise RecordError(f"array {name}: unknown compression {entry.compress_type}")
    with archive.open(entry) as file:
        if np.lib.format.read_magic(file) != (1, 0):
            raise RecordError(f"array {name}: not of .npy version 1.0")
        try:
            shape, fortran_order, stored = np.lib.format.read_array_header_1_0(file)
        except Exception as error:  # the header is Python source, whose errors are of many types
            raise RecordError(f"array {name}: damaged header") from error
        if stored != np.dtype(dtype) or len(shape) != dimensions or fortran_order:
            raise RecordError(
                f"array {name} is {stored} with {len(shape)} dimensions; "
                f"it must be {np.dtype(dtype)} with {dimensions}, in C order"
            )
        size = math.prod(shape) * stored.itemsize
        if size != entry.file_size - file.tell():
            raise RecordError(f"array {name} claims {size} bytes, which it does not have")
        data = file.read(size)
        file.read(1)  # zipfile checks the checksum only when the end has been read
    return np.frombuffer(data, dtype=stored).reshape(shape)
