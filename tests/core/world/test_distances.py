"""Distances round the walls, to the nearest of some cells."""

import math

import numpy as np
import pytest

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError
from warehouse_core.world.distances import distances


def test_they_are_counted_in_moves_round_the_walls() -> None:
    found = distances(Layout(["...", ".#.", ".#."]), [(2, 0)])
    assert found.tolist() == [[2, 3, 4], [1, math.inf, 5], [0, math.inf, 6]]


def test_they_are_those_to_the_nearest() -> None:
    assert distances(Layout(["......"]), [(0, 0), (0, 4)]).tolist() == [[0, 1, 2, 1, 0, 1]]


@pytest.mark.parametrize("cells", [[], [(1, 1)]])
def test_where_no_way_leads_they_are_infinite(cells: list[tuple[int, int]]) -> None:
    found = distances(Layout(["###.", "#.#.", "###."]), cells)
    assert np.isinf(found[:, 3]).all()
    assert found[1, 1] == (0 if cells else math.inf)


def test_a_way_never_leaves_the_grid() -> None:
    assert math.isinf(distances(Layout([".#", "#."]), [(0, 0)])[1, 1])
    assert math.isinf(distances(Layout(["#.", ".#"]), [(0, 1)])[1, 0])


def test_there_and_back_is_as_far() -> None:
    cells = [DEFAULT_LAYOUT.open_cell(index) for index in range(len(DEFAULT_LAYOUT.open_cells))]
    table = {cell: distances(DEFAULT_LAYOUT, [cell]) for cell in cells}
    assert all(table[a][b] == table[b][a] for a in cells for b in cells)


@pytest.mark.parametrize("cell", [(0, 0), (6, 11), (7, 0), (-1, 3)])
def test_a_cell_that_is_not_open_is_refused(cell: tuple[int, int]) -> None:
    with pytest.raises(LayoutError, match=f"cell row {cell[0]}, column {cell[1]} is"):
        distances(DEFAULT_LAYOUT, [cell])
