from itertools import permutations

import numpy as np
import pytest

from warehouse_core import Cell, Layout, random_layout
from warehouse_core.batch.floor import BatchFloor
from warehouse_core.task.encoding import MARKED_TILES, marks
from warehouse_core.task.sight import Sight
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import CELL_CODES

OPEN = Layout(["....", "....", "...."])
WALLED = random_layout(6, 5, 0.3, seed=2)
LANE = Layout(["......."])
BARE = [layout.with_stations(None, None) for layout in (OPEN, WALLED, LANE)]


def codes(window: list[str]) -> list[int]:
    return [CELL_CODES[tile] for line in window for tile in line]


def put(floor: BatchFloor, row: int, layout: Layout, *stations: Cell) -> None:
    pickups, dropoffs = ([at[0] * layout.width + at[1]] for at in stations)
    floor.put_stations(np.array([row]), np.array([pickups, dropoffs]))


@pytest.mark.parametrize("radius", [0, 1, 2, 8])
def test_windows_show_stations_only_where_they_are(radius: int) -> None:
    """Try all cells of pickup, dropoff and robot in layouts narrower and wider than the window."""
    floor, marked = (
        BatchFloor(LayoutSet(BARE), radius, moving_stations=True, tiles=tiles)
        for tiles in ((), MARKED_TILES)
    )
    for row, layout in enumerate(BARE):
        cells = [layout.open_cell(index) for index in range(len(layout.open_cells))]
        stream = np.random.default_rng(radius)
        pairs = list(permutations(cells, 2))
        for pickup, dropoff in [pairs[index] for index in stream.permutation(len(pairs))[:25]]:
            expected = Sight(radius)
            expected.use(layout.with_stations(pickup, dropoff))
            count = len(cells)
            loaded = stream.random(count) < 0.5
            for each in (floor, marked):
                put(each, row, layout, pickup, dropoff)
            given = np.full(count, row), layout.open_cells, loaded
            found = floor.windows(*given)
            assert found.dtype == np.uint8
            assert np.array_equal(marked.windows(*given), marks(found, MARKED_TILES))
            for cell, has_item, window in zip(cells, loaded, found.tolist(), strict=True):
                assert window == codes(expected.window(cell, bool(has_item))), (cell, pickup)


def test_windows_whose_marks_are_too_large_are_codes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_core.batch.floor.MAX_TABLE_BYTES", 3 * 12 * 9 - 1)
    kinds = {}
    for layout in (OPEN, LANE):
        floor = BatchFloor(LayoutSet([layout]), 1, moving_stations=False, tiles=MARKED_TILES)
        given = np.array([0]), np.array([5]), np.array([False])
        kinds[layout] = floor.windows(*given).dtype
    assert kinds == {OPEN: np.uint8, LANE: np.bool_}


def test_a_station_very_far_away_is_not_seen() -> None:
    """In 32 bits, an offset of 65,535 rows of 65,537 numbers would be -1."""
    length = 2**16
    layouts = LayoutSet([Layout(["."] * length), Layout(["." * length])])
    ends: list[tuple[Cell, Cell]] = [((0, 0), (length - 1, 0)), ((length - 1, 0), (0, 0))]
    floor = BatchFloor(layouts, 1, moving_stations=True)
    for robot, station in ends:
        put(floor, 0, layouts.kinds[0], station, station)
        found = floor.windows(np.array([0]), np.array([robot[0]]), np.array([False]))
        assert not {CELL_CODES["P"], CELL_CODES["D"]} & set(found.ravel().tolist())
