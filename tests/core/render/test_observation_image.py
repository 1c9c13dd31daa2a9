from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout, WarehouseEnv
from warehouse_core.render.observation_image import TILE_PIXELS, ObservationImage
from warehouse_core.render.painter import CODES, TilePainter
from warehouse_core.render.palette import BATTERY, FAINT, INK
from warehouse_core.task.encoding import encode

ROOM = Layout(["..P.", "D.#.", "...."])
IMAGE = ObservationImage(height=3, width=4, battery=10, max_steps=20)

KEYS = {
    **{tile: (tile, "") for tile in ".#PDC?"},
    **{robot: (".", robot) for robot in "Rr"},
    "A": ("P", "R"),
    "a": ("P", "r"),
    "B": ("D", "R"),
    "b": ("D", "r"),
}
"""The meaning of characters in a drawing: ``?`` not seen, A a robot on P, B one on D."""


def painted(*drawing: str) -> Any:
    """Return the picture of a drawing, without bars."""
    return TilePainter(TILE_PIXELS).paint([[CODES[KEYS[key]] for key in row] for row in drawing])


def picture(layout: Layout, cell: tuple[int, int], radius: int, loaded: bool = False) -> Any:
    env = WarehouseEnv(layout, cell, max_steps=20, battery=10, view_radius=radius)
    env.state.has_item = loaded
    return IMAGE.paint(encode(env.observe()))


def without_bars(pixels: Any) -> Any:
    return pixels[:-TILE_PIXELS]


@pytest.mark.parametrize(
    ("cell", "radius", "loaded", "drawing"),
    [
        ((0, 0), 1, False, ("R.P?", "D.??", "????")),
        ((2, 3), 1, True, ("??P?", "D?#.", "??.r")),
        ((1, 1), 1, False, ("..P?", "DR#?", "...?")),
        ((1, 1), 0, True, ("??P?", "Dr??", "????")),
        ((2, 0), 2, False, ("..P?", "D.#?", "R..?")),
        ((0, 2), 0, False, ("??A?", "D???", "????")),
        ((0, 2), 1, True, ("?.a.", "D.#.", "????")),
        ((1, 0), 9, False, ("..P.", "B.#.", "....")),
        ((1, 0), 1, True, ("..P?", "b.??", "..??")),
    ],
)
def test_only_seen_cells_and_stations_are_shown(cell, radius, loaded, drawing) -> None:
    found = picture(ROOM, cell, radius, loaded)
    assert (found.shape, found.dtype) == (IMAGE.shape, np.uint8)
    assert np.array_equal(without_bars(found), painted(*drawing))


def test_stations_in_view_and_the_first_of_each_kind_are_shown() -> None:
    shop = Layout(["...P", "P..D", ".P.D"])
    assert np.array_equal(without_bars(picture(shop, (2, 2), 1)), painted("???P", "?..D", "?PRD"))
    depot = Layout(["C..P", "C..D", "..C."])
    assert np.array_equal(without_bars(picture(depot, (2, 1), 1)), painted("???P", "C..D", ".RC?"))
    alone = Layout(["....", "....", "...."])
    assert np.array_equal(without_bars(picture(alone, (0, 0), 1)), painted("R.??", "..??", "????"))
    assert np.array_equal(without_bars(picture(alone, (0, 0), 0)), painted("R???", "????", "????"))
    # Only the first station of each kind is known to be under the robot.
    assert np.array_equal(without_bars(picture(shop, (1, 0), 0)), painted("???P", "R??D", "????"))


def test_the_bars_are_battery_and_steps() -> None:
    assert IMAGE.shape == (32, 32, 3)
    env = WarehouseEnv(ROOM, (0, 0), max_steps=20, battery=10)
    for _ in range(5):
        env.step("WAIT")
    bars = IMAGE.paint(encode(env.observe()))[-TILE_PIXELS:]
    half = TILE_PIXELS // 2
    for lines, color, share in ((bars[:half], BATTERY, 0.5), (bars[half:], INK, 0.25)):
        filled, ground = ([round(255 * part) for part in each] for each in (color, FAINT))
        middle = lines[half // 2]
        # One pixel at either end is empty; the pixel where the filling ends may be mixed.
        end = 1 + 30 * share
        assert (middle[1 : int(end)] == filled).all()
        assert (middle[int(end) + 1 :] == ground).all()
        assert (lines[[0, -1]] == ground).all()
        assert (middle[0] == ground).all()


def test_a_smaller_layout_is_shown_in_the_corner_of_a_larger_picture() -> None:
    """As in a batch of different layouts: cells beyond its edge are walls or not seen."""
    env = WarehouseEnv(Layout(["PD", ".."]), (1, 0), battery=10, max_steps=20, view_radius=1)
    found = IMAGE.paint(encode(env.observe()))
    assert np.array_equal(without_bars(found), painted("PD??", "R.??", "##??"))
