import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from warehouse_core import Layout
from warehouse_core.render.atlas import (
    BORDERS,
    CELLS,
    CODES,
    NO_ROBOT,
    ROBOT_CODES,
    SHELVES,
    SLIPPERY,
    WAITING_ITEM,
    atlas,
)
from warehouse_core.render.painter import TilePainter, bar, codes_of, paint_once, tile_pixels_for
from warehouse_core.render.palette import BATTERY, COLORS, FAINT, ICE, ICE_WAVE, WARNING
from warehouse_core.world.tiles import CELL_CODES

YARD = Layout(["#####", "#P.D#", "#.PC#", "#####"])
SIDES = (2, 3, 9, 10, 15, 16, 20, 40)


def where(image: NDArray[np.uint8], color: tuple[float, float, float]) -> NDArray[np.bool_]:
    return (np.abs(image - 255 * np.array(color)) <= 0.5 + 1e-9).all(axis=-1)


# Codes.


def test_the_codes_of_a_window_can_be_painted_as_they_are() -> None:
    for character, code in CELL_CODES.items():
        tile, robot = (".", character) if character in "RrOoH" else (character, NO_ROBOT)
        assert CELLS[code] == (tile, robot)


def test_each_cell_has_one_code() -> None:
    robots = {*itertools.product(".PDC", "RrH"), *itertools.product(".", "Oo")}
    robots |= {("P", WAITING_ITEM), ("#", SHELVES), *itertools.product("#", BORDERS)}
    robots |= {*itertools.product(".PDC", [SLIPPERY])}
    assert set(CELLS) == robots | {(tile, NO_ROBOT) for tile in ".#PDC?"}
    assert len(set(CELLS)) == len(CELLS)
    assert [CODES[cell] for cell in CELLS] == list(range(len(CELLS)))


@pytest.mark.parametrize("code", [len(CELLS), *ROBOT_CODES[:, CODES["#", NO_ROBOT]]])
def test_an_unknown_code_raises(code: int) -> None:
    with pytest.raises(IndexError):
        TilePainter(4).paint(np.full((2, 2), code, np.uint8))


# Cells.


@pytest.mark.parametrize("side", SIDES)
def test_any_two_cells_have_different_colours(side: int) -> None:
    tiles = atlas(side).astype(int)
    known = [code for code, (_, sign) in enumerate(CELLS) if sign not in (*BORDERS, SLIPPERY)]
    for one, other in itertools.combinations(known, 2):
        differences = np.abs(tiles[one] - tiles[other]).mean(axis=(0, 1))
        assert differences.max() > 15, (CELLS[one], CELLS[other])


@pytest.mark.parametrize("rows", [["##", "##"], ["#.#"], ["###", "#..", "###"]])
def test_walls_of_a_layout_without_a_whole_border_are_whole(rows: list[str]) -> None:
    layout = Layout(rows)
    picture = TilePainter(10).fleet_picture(layout, [])
    assert where(picture, COLORS["#"]).sum() == 100 * sum(line.count("#") for line in rows)


def test_slippery_floor_has_waves_below_stations_and_a_border_may_be_unseen() -> None:
    rows = ["###?", "#P.?", "#..#", "####"]
    codes = codes_of(rows, [(1, 1), (1, 2), (1, 3), (0, 0)])
    assert CELLS[codes[0, 3]] == ("?", NO_ROBOT)
    assert CELLS[codes[1, 1]] == ("P", SLIPPERY)
    assert CELLS[codes[1, 2]] == (".", SLIPPERY)
    assert CELLS[codes[1, 3]] == ("?", NO_ROBOT)
    assert CELLS[codes[0, 0]] == ("#", "NW")
    image = atlas(40)[CODES[".", SLIPPERY]]
    assert where(image, ICE).any()
    assert where(image, ICE_WAVE).any()
    assert not where(atlas(9)[CODES[".", SLIPPERY]], ICE_WAVE).any()


# Pictures.


def test_each_tile_is_where_its_code_is() -> None:
    codes = np.arange(48).reshape(2, 2, 3, 4) % len(CELLS)
    for side in (2, 5, 16, 64):  # with the last, offsets of tiles need more than 8 bits
        pictures = TilePainter(side).paint(codes.astype(np.uint8))
        assert pictures.shape == (2, 2, 3 * side, 4 * side, 3)
        assert pictures.dtype == np.uint8
        for place in np.ndindex(codes.shape):
            *batch, row, col = place
            rows, columns = (slice(at * side, (at + 1) * side) for at in (row, col))
            assert np.array_equal(pictures[*batch, rows, columns], atlas(side)[codes[place]])
        assert np.array_equal(paint_once(codes[1, 0], side), pictures[1, 0])


def test_a_picture_is_a_new_array() -> None:
    painter = TilePainter(8)
    first = painter.picture(YARD, (1, 1), False)
    kept = first.copy()
    first[:] = 0
    painter.paint(codes_of(YARD.rows))[:] = 0
    assert np.array_equal(painter.picture(YARD, (1, 1), False), kept)
    assert np.array_equal(TilePainter(8).picture(YARD, (1, 1), False), kept)


def test_tiles_are_drawn_once_and_read_only_have_2_pixels_at_least_and_walls_no_robot() -> None:
    assert atlas(12) is atlas(12)
    with pytest.raises(ValueError, match="read-only"):
        atlas(12)[:] = 0
    with pytest.raises(ValueError, match="at least 2"):
        TilePainter(1)
    with pytest.raises(KeyError):
        TilePainter(8).picture(YARD, (0, 0), False)


@settings(max_examples=30)
@given(st.integers(1, 4000), st.integers(1, 4000))
def test_tiles_are_even_and_as_large_as_fits(height: int, width: int) -> None:
    pixels, larger = tile_pixels_for(height, width), max(height, width)
    assert pixels % 2 == 0
    assert 2 <= pixels <= 40
    assert pixels == 2 or pixels * larger <= 1000
    assert pixels == 40 or (pixels + 2) * larger > 1000


# Bars.


def test_a_bar_is_filled_from_the_left() -> None:
    image = bar(0.25, 42, 6)
    assert image.shape == (6, 42, 3)
    assert image.dtype == np.uint8
    assert where(image[1:5, 1:11], BATTERY).all()
    assert where(image[:, 11:], FAINT).all()
    for edge in (image[0], image[-1], image[:, 0]):
        assert where(edge, FAINT).all()


def test_bars_have_any_colour_and_shares_are_limited_to_0_and_1() -> None:
    assert where(bar(1.0, 12, 5, WARNING)[1:-1, 1:-1], WARNING).all()
    assert np.array_equal(bar(-1, 10, 4), bar(0, 10, 4))
    assert np.array_equal(bar(2, 10, 4), bar(1, 10, 4))
