from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from helpers.map_files import grids, refusal
from hypothesis import given, settings

from warehouse_core import Layout, LayoutError
from warehouse_core.world.layout import MAX_CELLS, MAX_ROWS
from warehouse_core.world.map_files import MAX_BLANKS, load_layout, load_map, save_layout, save_map

HALL = Layout(["####", "#P.#", "#.D#", "####"])

HEADER = "type octile\nheight 2\nwidth 3\nmap\n"


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    return tmp_path / "hall.map"


def refused(file: Path, data: str | bytes) -> str:
    return refusal(load_map, file, data)


def test_every_terrain_is_floor_or_wall(hall: Path) -> None:
    hall.write_text("type octile\nheight 1\nwidth 7\nmap\n.GS@OTW\n")
    assert load_map(hall).rows == ("...####",)


@pytest.mark.parametrize(
    "text",
    [
        "type octile\nwidth 3\nheight 2\nmap\n..@\n.@@\n",
        "type octile\r\nheight 2\r\nwidth 3\r\nmap\r\n..@\r\n.@@\r\n",
        "\ufefftype octile \nheight  2\nwidth\t3 \nmap\t\n..@  \n.@@\t\n\n \n",
        f"{HEADER}..@\n.@@",
    ],
    ids=["width first", "Windows", "blanks", "no last line end"],
)
def test_variants_of_the_format_are_read(hall: Path, text: str) -> None:
    hall.write_bytes(text.encode())
    assert load_map(hall).rows == ("..#", ".##")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("", "line 1, column 1: '' is not allowed; it must be 'type octile'"),
        ("type tile\n", "line 1, column 1: 'type tile' is not allowed; it must be 'type octile'"),
        ("type octile\nwidth 3\nwidth 3\n", "line 3, column 1: 'width 3' is not allowed; it must be"
         " 'height N'"),
        ("type octile\nmap\n", "line 2, column 1: 'map' is not allowed; it must be 'height N' or"
         " 'width N'"),
        ("type octile\nheight\n", "line 2, column 1: 'height' is not allowed"),
        ("type octile\nheight -2\n", "line 2, column 8: height is '-2'; it must be a whole number,"
         " at least 1"),
        ("type octile\nheight 2\nwidth  0\n", "line 3, column 8: width is '0'; it must be"),
        ("type octile\nheight 1_0\n", "line 2, column 8: height is '1_0'; it must be"),
        ("type octile\nheight ²\n", "line 2, column 8: height is '²'; it must be"),
        ("type octile\nheight 2\nwidth 3\n..@\n", "line 4, column 1: '..@' is not allowed; it must"
         " be 'map'"),
        (b"type octile\nheight \xff\n", "line 2, column 8: not UTF-8 text"),
        ("x" * 5000, "line 1, column 1001: the line is longer than MAX_LINE = 1000 bytes"),
    ],
)  # fmt: skip
def test_an_invalid_header_raises_with_its_place(hall, data, message) -> None:
    assert refused(hall, data).startswith(message)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("...\n..E\n", "line 6, column 3: 'E' is no terrain; allowed: . G S (floor), "
         "@ O T W (not)"),
        ("...\n.ü.\n", "line 6, column 2: 'ü' is no terrain"),
        (b"...\n.\xff.\n", "line 6, column 2: '\ufffd' is no terrain"),
        ("...\n. .\n", "line 6, column 2: ' ' is no terrain"),
        ("...\r...\r", "line 5, column 4: '\\r' is no terrain"),
        ("...\n..\n", "line 6, column 3: the row ends here; its header says width 3"),
        ("...@\n...\n", "line 5, column 4: the row goes on here; its header says width 3"),
        ("", "line 5, column 1: the map ends here; its header says height 2"),
        ("...\n", "line 6, column 1: the map ends here; its header says height 2"),
        ("...\n...\n...\n", "line 7, column 1: the map goes on here; its header says height 2"),
        ("...\n...\n\n  x\n", "line 8, column 3: the map goes on here; its header says height 2"),
    ],
)  # fmt: skip
def test_invalid_rows_raise_with_their_place(hall: Path, rows: str | bytes, message: str) -> None:
    data = rows.encode() if isinstance(rows, str) else rows
    assert refused(hall, HEADER.encode() + data).startswith(message)


def test_blanks_after_a_row_have_a_limit(hall: Path) -> None:
    hall.write_text(f"{HEADER}...{' ' * (MAX_BLANKS - 1)}\n...{' ' * MAX_BLANKS}")
    assert load_map(hall).rows == ("...", "...")
    message = refused(hall, f"{HEADER}...{' ' * MAX_BLANKS}\n...\n")
    assert message == "line 5, column 20: more than MAX_BLANKS = 16 blanks follow the row"


@pytest.mark.parametrize(
    ("height", "width", "limit"),
    [
        (1, MAX_CELLS + 1, f"1 x {MAX_CELLS + 1} cells are more than MAX_CELLS = {MAX_CELLS}"),
        (
            10**50,
            10**50,
            f"the layout has {10**50} rows; at most MAX_ROWS = {MAX_ROWS} are allowed",
        ),
    ],
)
def test_a_map_that_is_too_large_raises_after_its_header(
    hall: Path,
    height: int,
    width: int,
    limit: str,
    little_memory: Callable[[], AbstractContextManager[None]],
) -> None:
    with little_memory():
        message = refused(hall, f"type octile\nheight {height}\nwidth {width}\nnonsense\n")
    assert message == f"line 3, column 7: {limit}"


def test_a_row_without_an_end_is_not_read_completely(hall, little_memory) -> None:
    with hall.open("wb") as file:
        file.write(HEADER.encode())
        file.write(b"." * 3)
        file.truncate(2 * 64 * 1024 * 1024)
    with little_memory(), pytest.raises(LayoutError, match=r"column 4: '\\x00' is no terrain"):
        load_map(hall)


@settings(max_examples=25)
@given(rows=grids())
def test_a_saved_map_has_the_same_walls_and_no_stations(tmp_path_factory, rows: list[str]) -> None:
    path = tmp_path_factory.getbasetemp() / "saved.map"
    save_map(Layout(rows), path)
    floor = [row.translate(dict.fromkeys(map(ord, "PDC"), ".")) for row in rows]
    assert load_map(path).rows == tuple(floor)


@pytest.mark.parametrize("name", ["hall.txt", "hall", "hall.map.txt", "hall.map", "HALL.MAP"])
def test_the_suffix_selects_the_format_and_a_map_keeps_only_the_walls(tmp_path, name: str) -> None:
    path, is_map = tmp_path / name, name.lower().endswith(".map")
    save_layout(HALL, path)
    assert path.read_text().startswith("type octile\n") == is_map
    assert load_layout(path) == (HALL.with_stations(None, None) if is_map else HALL)
    HALL.save(path)
    if is_map:
        with pytest.raises(LayoutError, match="line 1"):
            load_layout(path)


def test_empty_lines_at_the_end_have_a_limit(hall: Path) -> None:
    hall.write_text(f"{HEADER}...\n...\n{(MAX_BLANKS - 1) * chr(10)}")
    assert load_map(hall).height == 2
    message = refused(hall, f"{HEADER}...\n...\n{1000 * chr(10)}")
    assert message == "line 22, column 1: MAX_BLANKS = 16 or more empty lines at the end"
