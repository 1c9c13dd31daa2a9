from itertools import product
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError
from warehouse_core.world import layout as layout_module
from warehouse_core.world.layout import MAX_ROWS, check_open
from warehouse_core.world.tiles import ALLOWED_TILES

FIELDS = ("rows", "height", "width", "pickups", "dropoffs", "chargers")


@st.composite
def grids(draw: st.DrawFn) -> list[str]:
    width = draw(st.integers(1, 7))
    return draw(st.lists(st.text("#.PDC", min_size=width, max_size=width), min_size=1, max_size=7))


def cells_of(rows: list[str], tiles: str) -> list[tuple[int, int]]:
    """Find tiles one by one, in row-major order."""
    return [
        (row, col)
        for row in range(len(rows))
        for col in range(len(rows[0]))
        if rows[row][col] in tiles
    ]


def test_the_default_layout_is_the_chapters() -> None:
    assert DEFAULT_LAYOUT.rows == (
        "############",
        "#..P....#..#",
        "#..##...#..#",
        "#......##..#",
        "#..#.......#",
        "#..#..D....#",
        "############",
    )
    assert (DEFAULT_LAYOUT.height, DEFAULT_LAYOUT.width) == (7, 12)
    assert (DEFAULT_LAYOUT.pickups, DEFAULT_LAYOUT.dropoffs) == (((1, 3),), ((5, 6),))


@settings(max_examples=50)
@given(grids())
def test_every_field_follows_from_the_rows(rows: list[str]) -> None:
    layout = Layout(rows)
    assert layout.rows == tuple(rows)
    assert (layout.height, layout.width) == (len(rows), len(rows[0]))
    assert layout.pickups == tuple(cells_of(rows, "P"))
    assert layout.dropoffs == tuple(cells_of(rows, "D"))
    assert layout.chargers == tuple(cells_of(rows, "C"))
    open_cells = cells_of(rows, ".PDC")
    assert [layout.open_cell(index) for index in range(len(layout.open_cells))] == open_cells
    for cells in (layout.pickups, layout.dropoffs, layout.chargers):
        assert [layout.open_cell(rank) for rank in layout.ranks(cells)] == [*cells]
    for row, col in product(range(-2, layout.height + 2), range(-2, layout.width + 2)):
        assert layout.is_open((row, col)) == ((row, col) in open_cells)
    assert Layout.from_text(str(layout)) == layout


def test_a_cell_is_described_by_its_place_and_its_tile() -> None:
    layout = Layout(["#.", "PC"])
    assert layout.describe((0, 0)) == "row 0, column 0 is wall"
    assert layout.describe((1, 0)) == "row 1, column 0 is pickup"
    assert layout.describe((1, 1)) == "row 1, column 1 is charger"
    off = "row 2, column -1 is off the grid (rows 0..1, columns 0..1)"
    assert layout.describe((2, -1)) == off
    check_open(layout, (0, 1), "start")
    with pytest.raises(LayoutError, match=r"^start row 0, column 0 is wall; it must be an open"):
        check_open(layout, (0, 0), "start")


def test_the_default_start_is_the_chapters_or_the_first_open_cell() -> None:
    assert DEFAULT_LAYOUT.default_start() == (1, 1)
    assert Layout(["#P", "D#"]).default_start() == (0, 1)
    with pytest.raises(LayoutError, match="no open cell"):
        Layout(["##"]).default_start()


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "empty"),
        ([""], "empty"),
        (["...", ".."], "row 1 has 2 columns where row 0 has 3"),
        (["..", "..."], "row 1 has 3 columns where row 0 has 2"),
        (["..", ".?"], "row 1, column 1: '?' is not a tile"),
        (["R."], "row 0, column 0: 'R' is not a tile"),
        ([".é"], f"row 0, column 1: 'é' is not a tile; allowed: {ALLOWED_TILES}"),
        (["..", "", ".."], "row 1 has 0 columns"),
    ],
)
def test_an_invalid_layout_raises_with_its_place(rows: list[str], message: str) -> None:
    assert ALLOWED_TILES == "# (wall), . (empty), P (pickup), D (dropoff), C (charger)"
    for make in (Layout, lambda rows: Layout.from_text("\n".join(rows))):
        with pytest.raises(LayoutError) as caught:
            make(rows)
        assert message in str(caught.value)


@pytest.mark.parametrize("rows", ["..", 5, iter(["."]), ["..", b".."], ["..", 5]])
def test_rows_must_be_a_list_of_strings(rows: Any) -> None:
    named = "row 1 of the layout" if isinstance(rows, list) else "list of strings"
    with pytest.raises(TypeError, match=named):
        Layout(rows)


def test_a_layout_above_the_limit_raises(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(layout_module, "MAX_CELLS", 6)
    assert Layout(["...", "..."]).width == 3
    with pytest.raises(LayoutError, match="MAX_CELLS = 6"):
        Layout(["...."] * 2)
    with pytest.raises(LayoutError, match="text is longer than MAX_CELLS = 6"):
        Layout.from_text("." * 13)
    path = tmp_path / "large.txt"
    path.write_text("." * 1000)
    with pytest.raises(LayoutError, match=r"large\.txt.*MAX_CELLS = 6"):
        Layout.load(path)


@pytest.mark.parametrize("make", [Layout.from_text, str.splitlines])
def test_a_layout_of_very_many_rows_raises_before_they_are_looked_at(make, little_memory) -> None:
    rows = (MAX_ROWS + 1) * "?\n"
    with little_memory(), pytest.raises(LayoutError, match=f"at most MAX_ROWS = {MAX_ROWS}"):
        Layout(make(rows))


@pytest.mark.parametrize("data", [b"#.\r\nP#\r\n", b"\xef\xbb\xbf#.\nP#\n", b"  #. \n  P#  "])
def test_other_line_ends_a_byte_order_mark_and_blanks_are_accepted(tmp_path, data: bytes) -> None:
    path = tmp_path / "warehouse.txt"
    path.write_bytes(data)
    assert Layout.load(path).rows == ("#.", "P#")


@pytest.mark.parametrize(
    ("data", "message"), [(b"..\n\xff.", "UTF-8 text: byte 3"), (b"..\n.", "row 1")]
)
def test_the_error_of_an_invalid_file_names_it(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "broken.txt"
    path.write_bytes(data)
    with pytest.raises(LayoutError) as caught:
        Layout.load(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


@settings(max_examples=50)
@given(grids(), st.data())
def test_new_stations_replace_all_others(rows: list[str], data: st.DataObject) -> None:
    before = Layout(rows)
    spots = st.none() | st.sampled_from(cells_of(rows, ".PD") or [None])  # no charger
    pickup, dropoff = data.draw(spots), data.draw(spots)
    if pickup == dropoff:
        dropoff = None
    after = before.with_stations(pickup, dropoff)
    fresh = Layout(after.rows)
    assert all(getattr(after, name) == getattr(fresh, name) for name in FIELDS)
    assert after.open_cells is before.open_cells
    assert after.open_cells.tolist() == fresh.open_cells.tolist()
    assert after.pickups == (() if pickup is None else (pickup,))
    assert after.dropoffs == (() if dropoff is None else (dropoff,))
    assert after.chargers == before.chargers
    assert before == Layout(rows)


@pytest.mark.parametrize(
    ("tiles", "message"),
    [
        (([], [(0, 2)], [(0, 1), (0, 2)]), "row 0, column 2 is to be dropoff and charger; a cell"),
        (([(0, 3)], [], [(0, 3)]), "row 0, column 3 is to be pickup and charger"),
        (([(0, 1)], [(0, 1)], []), "row 0, column 1 is to be pickup and dropoff"),
        (([], [], [(0, 5)]), "charger row 0, column 5 is off the grid"),
        (([(0, 4)], [], []), "pickup row 0, column 4 is wall"),
        (([], [(-1, 1)], []), "dropoff row -1, column 1 is off"),
    ],
)
def test_a_station_or_charger_needs_an_open_cell_of_its_own(tiles: Any, message: str) -> None:
    with pytest.raises(LayoutError, match=message):
        Layout(["P.DC#"]).with_tiles(*tiles)


def test_reachable_cells_are_those_with_a_path() -> None:
    layout = Layout(["..#.", "P##.", "...D"])
    assert layout.reachable_from((0, 0)) == {
        (0, 0), (0, 1), (1, 0), (2, 0), (2, 1), (2, 2), (2, 3), (1, 3), (0, 3),
    }  # fmt: skip
    assert Layout([".#."]).reachable_from((0, 2)) == {(0, 2)}
    assert Layout([".#", "#."]).reachable_from((0, 0)) == {(0, 0)}
