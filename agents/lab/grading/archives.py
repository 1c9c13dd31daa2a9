"""Submissions that are ZIP archives: what is in them is checked before anything is unpacked.

An archive is written by a stranger: its index is bounded before it is read, no member is a link or
leaves the folder, and members are unpacked up to the sizes that were added up before.
"""

from __future__ import annotations

import shutil
import stat
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

from agents.errors import AgentError
from warehouse_core.files.reading import open_file

MAX_FILES, MAX_BYTES = 1_000, 256 * 1024**2
"""Most files and bytes of a submission, unpacked."""

MAX_INDEX, MAX_NAME = 512 * 1024, 512
"""Most bytes of the index of an archive, and of the path of a member."""

END, END_64 = b"PK\5\6", b"PK\6\7"
"""Signatures of the record that ends an archive, and of one that large archives have before it."""

END_LENGTH, END_64_LENGTH, MAX_COMMENT = 22, 20, 65_535


def members_of(path: Path) -> list[PurePosixPath]:
    """Return the files in an archive.

    Raises:
        AgentError: it is no archive, cannot be read, has links, files outside of its folder, or
            more than ``MAX_FILES`` or ``MAX_BYTES``.
    """
    with _open(path) as archive:
        return [PurePosixPath(member.filename) for member in _checked(archive)]


def read_member(path: Path, name: PurePosixPath, most: int) -> bytes:
    """Return the first bytes of a file in an archive, at most so many."""
    with _open(path) as archive, archive.open(str(name)) as file:
        return file.read(most)


def unpack(path: Path, folder: Path) -> None:
    """Unpack an archive into an empty folder; ``members_of`` says what raises."""
    with _open(path) as archive:
        for member in _checked(archive):
            target = folder / member.filename
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(member) as source, target.open("xb") as file:
                shutil.copyfileobj(source, file)


@contextmanager
def _open(path: Path) -> Iterator[ZipFile]:
    """Yield an archive with a bounded index; that something in it is wrong is an ``AgentError``."""
    try:
        with open_file(path) as file:
            file.seek(0, 2)
            size = file.tell()
            file.seek(max(size - END_LENGTH - MAX_COMMENT - END_64_LENGTH, 0))
            _check_end(file.read())
            file.seek(0)
            with ZipFile(file) as archive:
                yield archive
    except (BadZipFile, EOFError, NotImplementedError, RuntimeError, ValueError, OverflowError,
            OSError, KeyError, struct.error, zlib.error) as error:  # fmt: skip
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise AgentError(f"it cannot be unpacked: {reason}") from None


def _check_end(end: bytes) -> None:
    """Check the index of an archive by its last bytes, before the index is read."""
    place = end.rfind(END)
    if place < 0:
        raise BadZipFile("it is no ZIP archive")
    *_, count, index_bytes = struct.unpack_from("<4s4HL", end, place)
    is_large = end[max(place - END_64_LENGTH, 0) : place].startswith(END_64)
    if is_large or count > 2 * MAX_FILES or index_bytes > MAX_INDEX:
        raise BadZipFile(f"its index is of more than {MAX_FILES:,} files")


def _checked(archive: ZipFile) -> list[ZipInfo]:
    """Return the members that are files, if all may be unpacked."""
    found, left = dict[str, ZipInfo](), MAX_BYTES
    for member in archive.infolist():
        name = member.filename
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or "\\" in name or ":" in name:
            raise BadZipFile(f"{name!r} is a path out of its folder")
        if len(name.encode(errors="surrogateescape")) > MAX_NAME:
            raise BadZipFile(f"a path has more than {MAX_NAME} bytes")
        if stat.S_IFMT(member.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise BadZipFile(f"{name!r} is a link, or no file")
        if member.flag_bits & 1:
            raise BadZipFile(f"{name!r} is encrypted")
        if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            raise BadZipFile(f"{name!r} is compressed by a method that is not supported")
        if member.is_dir():
            continue
        if str(path) in found:
            raise BadZipFile(f"{name!r} is in it twice")
        member.filename = str(path)
        found[str(path)] = member
        left -= member.file_size
    if left < 0 or len(found) > MAX_FILES:
        raise BadZipFile(f"it has more than {MAX_FILES:,} files or {MAX_BYTES // 1024**2:,} MiB")
    return list(found.values())
