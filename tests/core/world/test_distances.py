import math

import numpy as np
import pytest
from helpers.map_files import grids
from hypothesis import given, settings
from hypothesis import strategies as st

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError
from warehouse_core.world.distances import distances, nearest
from warehouse_core.world.tiles import MOVE_DELTAS, moved


def test_distances_are_moves_around_walls() -> None:
    found = distances(Layout(["...", ".#.", ".#."]), [(2, 0)])
    assert found.tolist() == [[2, 3, 4], [1, math.inf, 5], [0, math.inf, 6]]


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


def test_distances_are_to_the_nearest_of_the_cells() -> None:
    assert distances(Layout(["......"]), [(0, 0), (0, 4)]).tolist() == [[0, 1, 2, 1, 0, 1]]


@pytest.mark.parametrize("cells", [[(0, 4), (0, 0)], [(0, 0), (0, 4), (0, 0)]])
def test_the_first_of_the_nearest_cells_wins_a_tie(cells: list[tuple[int, int]]) -> None:
    assert nearest(Layout(["......#."]), cells).tolist() == [[0, 0, 0, 4, 4, 4, -1, -1]]


@pytest.mark.parametrize("cells", [[], [(1, 1)]])
def test_distances_without_a_path_are_infinite(cells: list[tuple[int, int]]) -> None:
    found = distances(Layout(["###.", "#.#.", "###."]), cells)
    assert np.isinf(found[:, 3]).all()
    assert found[1, 1] == (0 if cells else math.inf)


def test_paths_are_neither_diagonal_nor_across_an_edge() -> None:
    assert math.isinf(distances(Layout([".#", "#."]), [(0, 0)])[1, 1])
    assert math.isinf(distances(Layout(["#.", ".#"]), [(0, 1)])[1, 0])
    assert math.isinf(distances(Layout([".", "#", "."]), [(0, 0)])[2, 0])


@pytest.mark.parametrize("cell", [(0, 0), (7, 0)])
def test_a_cell_that_is_not_open_raises(cell: tuple[int, int]) -> None:
    with pytest.raises(LayoutError, match=f"cell row {cell[0]}, column {cell[1]} is"):
        distances(DEFAULT_LAYOUT, [cell])
