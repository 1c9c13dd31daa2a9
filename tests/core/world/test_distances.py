import math

import pytest
from helpers.map_files import grids
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError
from warehouse_core.world.distances import distances, nearest
from warehouse_core.world.tiles import MOVE_DELTAS, moved


@settings(max_examples=30)
@given(grids(), st.data())
def test_distances_are_those_of_a_slow_search(rows: list[str], data: st.DataObject) -> None:
    layout = Layout(rows)
    cells = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    if cells:
        start = data.draw(st.sampled_from(cells))
        expected, ring = {start: 0}, [start]
        while ring:
            moves = [moved(cell, delta) for cell in ring for delta in MOVE_DELTAS.values()]
            ring = [cell for cell in dict.fromkeys(moves) if layout.is_open(cell)]
            ring = [cell for cell in ring if cell not in expected]
            expected |= dict.fromkeys(ring, max(expected.values()) + 1)
        found = distances(layout, [start])
        assert [found[cell] for cell in cells] == [expected.get(cell, math.inf) for cell in cells]


@pytest.mark.parametrize("cells", [[(0, 4), (0, 0)], [(0, 0), (0, 4), (0, 0)]])
def test_the_first_of_the_nearest_cells_wins_a_tie(cells: list[tuple[int, int]]) -> None:
    assert nearest(Layout(["......#."]), cells).tolist() == [[0, 0, 0, 4, 4, 4, -1, -1]]


@pytest.mark.parametrize("cell", [(0, 0), (7, 0)])
def test_a_cell_that_is_not_open_raises(cell: tuple[int, int]) -> None:
    with pytest.raises(LayoutError, match=f"cell row {cell[0]}, column {cell[1]} is"):
        distances(DEFAULT_LAYOUT, [cell])
