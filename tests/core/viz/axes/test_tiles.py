"""The tiles of a layout as shapes, in cells."""

from typing import Any

import pytest
from matplotlib.figure import Figure

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import BOARD, COLORS, ICE
from warehouse_core.render.palette import SHELF as SHELF_COLOR
from warehouse_core.viz.axes.tiles import BAND, MIN_BOARDS, MIN_WAVES, cells_of, draw_tiles

SHELF = ["....", ".##.", "...."]


@pytest.mark.parametrize(
    ("rows", "slippery", "least"), [(SHELF, [], MIN_BOARDS), (["..."] * 3, [(1, 1)], MIN_WAVES)]
)
def test_small_cells_have_no_texture(
    rows: list[str], slippery: list[tuple[int, int]], least: float
) -> None:
    def count(cell_points: float) -> int:
        return len(draw_tiles(Figure().add_subplot(), rows, cell_points, slippery))

    assert count(least) == count(least - 0.1) + 1


def drawn(rows: list[str], cell_points: float = 40.0, **options: Any) -> dict[Any, list[Any]]:
    """Return left, top, right and bottom of the shapes of each colour."""
    axes, found = Figure().add_subplot(), dict[Any, list[Any]]()
    for artist in draw_tiles(axes, rows, cell_points, **options):
        color: Any = getattr(artist, "get_facecolor", lambda: ())()
        if len(color) == 1 and hasattr(artist, "get_paths"):
            corners = [path.vertices for path in artist.get_paths()]
            found[tuple(color[0][:3])] = [
                (*each.min(axis=0), *each.max(axis=0)) for each in corners
            ]
    return found


def test_walls_along_the_border_are_a_band_next_to_the_floor() -> None:
    outer = 1 - BAND
    assert sorted(drawn(["####", "#..#", "####"])[COLORS["#"]]) == [
        pytest.approx(box)
        for box in sorted([
            (outer, outer, 1, 1), (1, outer, 2, 1), (2, outer, 3, 1), (3, outer, 3 + BAND, 1),
            (outer, 1, 1, 2), (3, 1, 3 + BAND, 2),
            (outer, 2, 1, 2 + BAND), (1, 2, 2, 2 + BAND), (2, 2, 3, 2 + BAND),
            (3, 2, 3 + BAND, 2 + BAND),
        ])
    ]  # fmt: skip
    assert drawn([".#."])[COLORS["#"]] == [(1, 0, 2, 1)], "there is no inside of one row"
    assert drawn([".", "#"])[COLORS["#"]] == [pytest.approx((0, 1, 1, 1 + BAND))]


def test_a_shelf_fills_its_cell_and_has_two_boards() -> None:
    found = drawn(["....", ".#..", "...."])
    assert found[SHELF_COLOR] == [(1, 1, 2, 2)]
    upper, lower = found[BOARD]
    for left, top, right, bottom in (upper, lower):
        assert 1 < left < 1.2 < 1.8 < right < 2
        assert left - 1 == pytest.approx(2 - right)
        assert 0.05 < bottom - top < 0.15
    assert 1.2 < upper[1] < upper[3] < 1.5 < lower[1] < lower[3] < 1.8


def test_a_station_is_a_square_in_its_cell_and_never_too_small() -> None:
    for cell_points, least in ((40.0, 0.8), (4.0, 1.5)):
        found = drawn([".P.", "..C", "D.."], cell_points)
        for tile, (x, y) in (("P", (1, 0)), ("C", (2, 1)), ("D", (0, 2))):
            [(left, top, right, bottom)] = found[COLORS[tile]]
            assert (left + right, top + bottom) == pytest.approx((2 * x + 1, 2 * y + 1))
            assert least < right - left == pytest.approx(bottom - top)
            assert (right - left < 1) == (cell_points == 40.0)


def test_slippery_floor_and_cells_not_seen_fill_their_cells() -> None:
    [box] = drawn(["...", "..."], slippery=[(1, 2)])[ICE]
    assert box == pytest.approx((2, 1, 3, 2), abs=0.05)
    rows = ["..", f".{UNSEEN}"]
    assert cells_of(UNSEEN, rows) == [(1, 1)]
    assert [(1, 1, 2, 2)] in drawn(rows).values()
