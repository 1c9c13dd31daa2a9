"""Damaged and hostile files raise ``RecordError`` quickly, without using much memory."""

import io
import struct
import zipfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

from warehouse_core import Episode, RecordError
from warehouse_core.files import npz as npz_module
from warehouse_core.files.npz import MAX_BYTES, Arrays, Schema, read_arrays, write_arrays

SCHEMA: Schema = {"words": ("<i4", 1), "points": ("<f8", 2)}
Members = dict[str, bytes]
Watch = Callable[[], AbstractContextManager[None]]
Refused = Callable[[bytes], str]


def good_arrays() -> Arrays:
    return {"words": np.arange(5, dtype="<i4"), "points": np.ones((3, 2))}


def npy(array: np.ndarray, *, pickled: bool = False) -> bytes:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=pickled)
    return file.getvalue()


def npy_with_header(header: str, data: bytes = b"", version: bytes = b"\x01\x00") -> bytes:
    text = header.encode("latin1").ljust(118) + b"\n"
    size = struct.pack("<H" if version == b"\x01\x00" else "<I", len(text))
    return b"\x93NUMPY" + version + size + text + data


def zipped(
    members: Members | list[tuple[str, bytes]], method: int = zipfile.ZIP_DEFLATED
) -> bytearray:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, data in members.items() if isinstance(members, dict) else members:
            archive.writestr(name, data)
    return bytearray(file.getvalue())


def with_end_record(data: bytearray, **fields: int) -> bytearray:
    """Return a zip file with changed fields in the end record, which describes its directory."""
    names = ("signature", "disk", "start", "here", "entries", "size", "offset", "comment")
    record = dict(zip(names, struct.unpack("<4s4H2LH", data[-22:]), strict=True))
    return data[:-22] + struct.pack("<4s4H2LH", *(record | fields).values())


def with_directory_of(data: bytearray, count: int) -> bytearray:
    """Return a zip file whose directory is ``count`` copies of its first entry."""
    start, second = data.index(b"PK\x01\x02"), data.rindex(b"PK\x01\x02")
    directory = data[start:second] * count
    crowded = data[:start] + directory + data[-22:]
    return with_end_record(crowded, entries=count, here=count, size=len(directory))


def in_directory(data: bytearray, offset: int, value: bytes) -> bytearray:
    """Overwrite a field of the first directory entry."""
    start = data.index(b"PK\x01\x02") + offset
    data[start : start + len(value)] = value
    return data


GOOD: Members = {f"{name}.npy": npy(array) for name, array in good_arrays().items()}
WORDS, POINTS = GOOD.values()
MORE = zipped(GOOD | {"more.npy": npy(np.zeros(1))})
CROWDED = with_directory_of(zipped(GOOD), 60_000)
LOCATOR = struct.pack("<4sLQL", b"PK\x06\x07", 0, 0, 1)


@pytest.fixture
def refused(tmp_path: Path, little_memory: Watch) -> Refused:
    """Return a function that returns the error message of a file."""

    def refuse(data: bytes) -> str:
        path = tmp_path / "hostile.npz"
        path.write_bytes(data)
        with little_memory(), pytest.raises(RecordError) as caught:
            read_arrays(path, SCHEMA)
        message = str(caught.value)
        assert message.startswith(f"{path}: ")
        assert len(message) < 2000
        return message

    return refuse


# Round trips.


def test_arrays_are_read_as_written(tmp_path: Path) -> None:
    write_arrays(tmp_path / "a.npz", good_arrays(), SCHEMA)
    arrays = read_arrays(tmp_path / "a.npz", SCHEMA)
    assert arrays.keys() == SCHEMA.keys()
    for name, array in good_arrays().items():
        assert np.array_equal(arrays[name], array)
        assert arrays[name].dtype == array.dtype
        assert not arrays[name].flags.writeable


def test_arrays_above_the_limit_are_not_written(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(npz_module, "MAX_BYTES", 67)
    with pytest.raises(RecordError, match="68 bytes are more than MAX_BYTES = 67"):
        write_arrays(tmp_path / "a.npz", good_arrays(), SCHEMA)
    assert list(tmp_path.iterdir()) == []


# Files of another format, with other arrays, or with invalid members.


@pytest.mark.parametrize(
    ("data", "message"),
    [
        *[(data, "not an .npz file") for data in (b"", b"not a record\n" * 9, b"PK\x05\x06")],
        (bytes(22), "not an .npz file"),
        (zipped(GOOD)[:-22] + LOCATOR + zipped(GOOD)[-22:], "not an .npz file"),
        (zipped({}), "0 arrays; there must be 2"),
        (zipped({"words.npy": WORDS}), "1 arrays; there must be 2"),
        (MORE, "3 arrays; there must be 2"),
        (with_end_record(MORE, entries=2, here=2), "'more.npy'"),
        *[
            (zipped({name: WORDS, "points.npy": POINTS}), "there must be")
            for name in ("wordy.npy", "words", "../words.npy", "WORDS.npy")
        ],
        (CROWDED, "60000 arrays"),
        (with_end_record(CROWDED, entries=2, here=2), "directory of"),
        *[
            (with_end_record(zipped(GOOD), **{field: value}), "")
            for field in ("size", "offset")
            for value in (1, 0xFFFFFFFF)
        ],
        (in_directory(zipped(GOOD), 8, b"\x01\x00"), "encrypted"),
        (in_directory(zipped(GOOD), 10, b"\x09\x00"), "array words: unknown compression 9"),
        (in_directory(zipped(GOOD), 10, b"\x0e\x00"), "array words: unknown compression 14"),
        *[
            (in_directory(zipped(GOOD, method), 16, bytes(4)), "CRC")
            for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        ],
        (in_directory(zipped(GOOD), 24, b"\xff\xff\xff\x7f"), f"MAX_BYTES = {MAX_BYTES}"),
    ],
)
def test_a_file_of_another_kind_raises(refused: Refused, data: bytes, message: str) -> None:
    assert message in refused(data)


def test_a_member_that_states_a_wrong_size_is_not_unpacked(refused: Refused) -> None:
    bomb = npy_with_header(header_of("'<i4'"), bytes(MAX_BYTES - 1000))
    packed = zipped({"words.npy": bomb, "points.npy": POINTS})
    assert len(packed) < 500_000
    assert "claims 20 bytes, which it does not have" in refused(packed)
    small = in_directory(packed, 24, struct.pack("<L", 128 + 20))
    assert "CRC" in refused(small)


def test_the_limit_is_on_all_members_together(refused: Refused, monkeypatch) -> None:
    monkeypatch.setattr(npz_module, "MAX_BYTES", 1000)
    half = bytes(501)
    assert "MAX_BYTES" in refused(zipped({"words.npy": half, "points.npy": half}))
    monkeypatch.setattr(npz_module, "MAX_BYTES", 1002)
    assert "MAX_BYTES" not in refused(zipped({"words.npy": half, "points.npy": half}))


def header_of(kind: str, shape: str = "(5,)", fortran_order: bool = False) -> str:
    return f"{{'descr': {kind}, 'fortran_order': {fortran_order}, 'shape': {shape}}}"


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (header_of("'<i4'", "(1000000000000,)"), "claims"),
        (header_of("'<i4'", "(6,)"), "claims 24 bytes"),
        (header_of("'<i4'", "(-5,)"), "claims -20 bytes"),
        (header_of("'<i4'", "()"), "with 0 dimensions"),
        (header_of("'<i4'", "(5, 1)"), "with 2 dimensions"),
        (header_of("'<i4'", fortran_order=True), "in C order"),
        (header_of("'>i4'"), "it must be int32"),
        (header_of("'|O'"), "it must be int32"),
        (header_of("[('a', '<i4')]"), "it must be int32"),
        (header_of("()"), "damaged header"),
        ("{'descr': '<i4', 'fortran_order': False}", "damaged header"),
        ("{[]: 1}", "damaged header"),
        ("(" * 118, "damaged header"),
        ("\0", "damaged header"),
        ("__import__('os').getcwd()", "damaged header"),
        *[
            ((text * depth)[: min(depth, 0xFFFF - 1)], "damaged header")
            for text, depth in (("-", 9_000), ("{1:", 9_000), ("(", 60_000))
        ],
    ],
)
def test_a_member_with_a_wrong_header_raises(refused: Refused, header: str, message: str) -> None:
    words = npy_with_header(header, bytes(20))
    assert message in refused(zipped(GOOD | {"words.npy": words}))


class Trap:
    """Records that it has been unpickled."""

    sprung = False

    def __reduce__(self) -> tuple[type, tuple[()]]:
        return (spring, ())


def spring() -> None:
    Trap.sprung = True


def test_a_pickle_raises_and_is_not_loaded(refused: Refused) -> None:
    words = npy(np.array([Trap()], dtype=object), pickled=True)
    assert "it must be int32" in refused(zipped(GOOD | {"words.npy": words}))
    assert not Trap.sprung


# Damage.


def test_a_truncated_record_raises(saved: Path) -> None:
    content = saved.read_bytes()
    path = saved.with_name("short.npz")
    for length in [*range(0, len(content), 101), len(content) - 1]:
        path.write_bytes(content[:length])
        with pytest.raises(RecordError):
            Episode.load(path)


@pytest.mark.parametrize("version", [b"\x02\x00", b"\xff\xff"])
def test_another_npy_version_raises(refused: Refused, version: bytes) -> None:
    words = npy_with_header(header_of("'<i4'"), bytes(20), version)
    assert "array words: not of" in refused(zipped(GOOD | {"words.npy": words}))
