"""Archives: sizes are limited, and neither paths nor links lead out of the folder."""

import os
import stat
import struct
import warnings
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from zipfile import ZIP_DEFLATED, ZIP_LZMA, ZipFile, ZipInfo

import pytest

from agents.errors import AgentError
from agents.lab.grading import archives
from agents.lab.grading.archives import members_of, read_member, unpack

Write = Callable[[ZipFile], object]


def archive_of(folder: Path, write: Write) -> Path:
    path = folder / "one.zip"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a name that is in it twice
        with ZipFile(path, "w", ZIP_DEFLATED) as archive:
            write(archive)
    return path


def special(kind: int) -> ZipInfo:
    info = ZipInfo("special.py")
    info.external_attr = (kind | 0o777) << 16
    return info


def lying(archive: ZipFile) -> None:
    """Write a member that is longer than its stated size."""
    archive.writestr("agent.py", b"x" * 1000)
    archive.infolist()[0].file_size = 10


BAD: dict[str, Write] = {
    "'/etc/passwd' is a path out": lambda archive: archive.writestr("/etc/passwd", ""),
    "'a/../../b' is a path out": lambda archive: archive.writestr("a/../../b", ""),
    r"'a\\\\..\\\\..\\\\b' is a path out": lambda archive: archive.writestr("a\\..\\..\\b", ""),
    r"'\\\\etc\\\\b' is a path out": lambda archive: archive.writestr("\\etc\\b", ""),
    "'C:b' is a path out": lambda archive: archive.writestr("C:b", ""),
    "'special.py' is a link": lambda archive: archive.writestr(special(stat.S_IFLNK), "/etc"),
    "special.py' is a link or a special file": lambda archive: archive.writestr(
        special(stat.S_IFIFO), ""
    ),
    "a path has more than 512 bytes": lambda archive: archive.writestr("a/" * 300, ""),
    "'a' is in the archive twice": lambda archive: [archive.writestr("a", "") for _ in range(2)],
    "more than 3 files or 1 MiB": lambda archive: [archive.writestr(n, "") for n in "abcd"],
    "3 files or 1 MiB": lambda archive: archive.writestr("zeros", bytes(1024**2 + 1)),
    "its index has more than 3 files": lambda archive: [
        archive.writestr(str(n), "") for n in range(7)
    ],
    "by a method that is not supported": lambda archive: archive.writestr("a", "", ZIP_LZMA),
    "cannot be unpacked: File exists": lambda archive: [
        archive.writestr(name, "") for name in ("a", "a/b")
    ],
    "Bad CRC-32": lying,
}


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MAX_FILES", 3)
    monkeypatch.setattr(archives, "MAX_BYTES", 1024**2)


@pytest.mark.parametrize(("reason", "write"), BAD.items(), ids=BAD)
def test_an_archive_that_is_not_as_it_should_be_is_refused(tmp_path, reason, write) -> None:
    path, folder = archive_of(tmp_path, write), tmp_path / "inner" / "folder"
    folder.mkdir(parents=True)
    with pytest.raises(AgentError, match=reason):
        unpack(path, folder)
    assert {each.name for each in tmp_path.iterdir()} == {"one.zip", "inner"}
    assert [each.name for each in folder.parent.iterdir()] == ["folder"]


def test_files_are_unpacked_and_folders_are_none(tmp_path: Path) -> None:
    def write(archive: ZipFile) -> None:
        archive.mkdir("src")
        archive.writestr("src/agent.py", "one")
        archive.comment = b"many words"

    path = archive_of(tmp_path, write)
    unpack(path, tmp_path)
    assert (tmp_path / "src" / "agent.py").read_text() == "one"
    assert list(map(str, members_of(path))) == ["src/agent.py"]


def test_paths_with_backslashes_and_suffixes_in_capitals_are_unpacked(tmp_path: Path) -> None:
    """Windows PowerShell 5 writes such paths, and macOS writes decomposed Unicode."""

    def write(archive: ZipFile) -> None:
        archive.writestr("agent\\", "")
        archive.writestr("agent\\A.PY", "one")
        archive.writestr("agent\\zoe\u0308.py", "two")

    path = archive_of(tmp_path, write)
    found = sorted(map(str, members_of(path)))
    assert found == ["agent/A.py", "agent/zo\u00eb.py"]
    assert read_member(path, PurePosixPath("agent/A.py"), 2) == b"on"
    unpack(path, tmp_path)
    assert [(tmp_path / name).read_text() for name in found] == ["one", "two"]


def test_what_is_no_archive_or_has_a_large_index_is_refused_before_it_is_read(tmp_path) -> None:
    path = archive_of(tmp_path, lambda archive: archive.writestr("a", ""))
    data = path.read_bytes()
    large = data[:-10] + struct.pack("<L", 2**30) + data[-6:]
    encrypted = bytearray(data)
    encrypted[data.index(b"PK\1\2") + 8] |= 1
    for text, reason in (
        (b"", "it is not a ZIP archive"), (b"PK", "it is not a ZIP archive"), (data[:-4], "unpack"),
        (large, "its index has more"), (encrypted, "'a' is encrypted"),
        (data[:-22] + b"PK\6\7".ljust(20, b"\0") + data[-22:], "its index has more"),
    ):  # fmt: skip
        path.write_bytes(text)
        with pytest.raises(AgentError, match=reason):
            members_of(path)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(AgentError, match="it is a pipe, not a file"):
        members_of(path)
