"""Private copies of submissions: ZIP archives, which are unpacked, and files, which are copied.

Archives are untrusted. The size of the index is checked before the index is read. No member may be
a link or leave the folder, and each member is unpacked only up to the size that the index states.
"""

from __future__ import annotations

import os
import shutil
import stat
import struct
import unicodedata
import zlib
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path, PurePath, PurePosixPath
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo

from agents.errors import AgentError
from warehouse_core.files.reading import open_file

CODE, NOTEBOOK = ".py", ".ipynb"

MAX_FILES, MAX_BYTES = 1_000, 256 * 1024**2
"""Limits on the files of a submission and on their bytes, unpacked."""

DATES = (2**31 - 1, 0)
"""Dates of the last access and of the last change of each file, in seconds since 1970.

Linux sets the date of access only if it is earlier than another date, or is a day old."""

MAX_INDEX, MAX_NAME = 512 * 1024, 512
"""Limits on the bytes of the index of an archive, and of the path of a member."""

END, END_64 = b"PK\5\6", b"PK\6\7"
"""Signatures of the last record of an archive, and of a record before it in large archives."""

END_LENGTH, END_64_LENGTH, MAX_COMMENT = 22, 20, 65_535


def place_of(path: PurePath) -> PurePath:
    """Return the path of a file in a private copy, where Python finds it.

    Code gets a suffix in lower case, and a name in composed Unicode, as imports have it.
    """
    suffix = path.suffix.lower()
    if suffix not in (CODE, NOTEBOOK):
        return path
    return path.with_name(unicodedata.normalize("NFC", path.stem) + suffix)


def members_of(path: Path) -> list[PurePosixPath]:
    """Return the files in an archive.

    Raises:
        AgentError: the file is not an archive, cannot be read, has links or files outside of its
            folder, or exceeds ``MAX_FILES`` or ``MAX_BYTES``.
    """
    with _open(path) as archive:
        return [PurePosixPath(member.filename) for member in _checked(archive)]


def read_member(path: Path, name: PurePath, most: int) -> bytes:
    """Return the first ``most`` bytes of a file in an archive."""
    with _open(path) as archive:
        member = next(each for each in _checked(archive) if each.filename == str(name))
        with archive.open(member) as file:
            return file.read(most)


def unpack(path: Path, folder: Path) -> None:
    """Unpack an archive into an empty folder; it raises the same errors as ``members_of``."""
    with _open(path) as archive:
        for member in _checked(archive):
            target = folder / member.filename
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(member) as source, target.open("xb") as file:
                shutil.copyfileobj(source, file)


def copy_files(
    files: Iterable[tuple[Path, PurePath]], folder: Path, hidden: Collection[Path]
) -> None:
    """Copy readable files and links to their places in a folder, except for hidden files.

    Links are copied as links, because their targets may belong to others.
    """
    for file, place in files:
        is_readable = file.is_file() and os.access(file, os.R_OK)
        if file not in hidden and (file.is_symlink() or is_readable):
            target = folder / place
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target, follow_symlinks=False)


def set_dates(folder: Path) -> None:
    """Give a folder and all that it contains the same dates."""
    for path in [*folder.rglob("*"), folder]:
        os.utime(path, DATES, follow_symlinks=not path.is_symlink())


@contextmanager
def _open(path: Path) -> Iterator[ZipFile]:
    """Yield an archive after checking the size of its index; damage raises ``AgentError``."""
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
        raise BadZipFile("it is not a ZIP archive")
    *_, count, index_bytes = struct.unpack_from("<4s4HL", end, place)
    is_large = end[max(place - END_64_LENGTH, 0) : place].startswith(END_64)
    if is_large or count > 2 * MAX_FILES or index_bytes > MAX_INDEX:
        raise BadZipFile(f"its index has more than {MAX_FILES:,} files")


def _checked(archive: ZipFile) -> list[ZipInfo]:
    """Return the members that are files, or raise if any member must not be unpacked.

    Some programs on Windows write paths with backslashes.
    """
    found, left = dict[str, ZipInfo](), MAX_BYTES
    for member in archive.infolist():
        name = member.filename
        member.filename = name.replace("\\", "/")
        path = place_of(PurePosixPath(member.filename))
        if path.is_absolute() or ".." in path.parts or ":" in name:
            raise BadZipFile(f"{name!r} is a path outside of its folder")
        if len(name.encode(errors="surrogateescape")) > MAX_NAME:
            raise BadZipFile(f"a path has more than {MAX_NAME} bytes")
        if stat.S_IFMT(member.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise BadZipFile(f"{name!r} is a link or a special file")
        if member.flag_bits & 1:
            raise BadZipFile(f"{name!r} is encrypted")
        if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
            raise BadZipFile(f"{name!r} is compressed by a method that is not supported")
        if member.is_dir():
            continue
        if str(path) in found:
            raise BadZipFile(f"{name!r} is in the archive twice")
        member.filename = str(path)
        found[str(path)] = member
        left -= member.file_size
    if left < 0 or len(found) > MAX_FILES:
        raise BadZipFile(f"it has more than {MAX_FILES:,} files or {MAX_BYTES // 1024**2:,} MiB")
    return list(found.values())
