"""Distances around walls from every cell to the nearest of a set of cells."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.edges import Edges
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Integers
from warehouse_core.world.tiles import Cell

Distances = NDArray[np.float64]
"""``[H, W]`` numbers of moves N, E, S or W; infinite for walls and for cells without a path."""


def distances(layout: Layout, cells: Collection[Cell]) -> Distances:
    """Return the number of moves from each cell to the nearest of ``cells``, all of them open."""
    return _nearest(layout, cells)[0]


def nearest(layout: Layout, cells: Collection[Cell]) -> NDArray[np.intp]:
    """Return the nearest of ``cells`` for each cell, ``[H, W]`` cell numbers; -1 without a path.

    Ties are broken in favour of the first cell in row-major order.
    """
    return _nearest(layout, cells)[1]


def _nearest(layout: Layout, cells: Collection[Cell]) -> tuple[Distances, NDArray[np.intp]]:
    """Return the moves from each cell to the nearest of ``cells``, and the number of that cell."""
    for cell in cells:
        check_open(layout, cell, "cell")
    moves = np.full(layout.height * layout.width, np.inf)
    which = np.full(layout.height * layout.width, -1, np.intp)
    if cells:
        numbers = np.unique(layout.numbers(cells))
        count, scale = len(layout.open_cells), len(numbers) + 1
        starts, ends = _moves(layout)
        # A root node has edges of costs 1, 2, ... to the cells, and a move costs more than the
        # largest difference of these. So the order of the cells breaks ties in every SciPy version.
        costs = np.append(np.full(len(starts), scale), np.arange(1, scale)).astype(np.float64)
        starts = np.append(starts, np.full(len(numbers), count))
        ends = np.append(ends, np.searchsorted(layout.open_cells, numbers))
        lengths = Edges(starts, ends, costs, count + 1).cheapest([count])[:count]
        reached = np.isfinite(lengths)
        steps, source = np.divmod(lengths[reached], scale)
        moves[layout.open_cells[reached]] = steps
        which[layout.open_cells[reached]] = numbers[source.astype(np.intp) - 1]
    shape = layout.height, layout.width
    return moves.reshape(shape), which.reshape(shape)


def _moves(layout: Layout) -> tuple[Integers, Integers]:
    """Return the starts and the ends of all moves between open cells, ``[E]`` each, by start.

    A cell is given by its index in ``open_cells``.
    """
    # With a closed column on the right and closed rows above and below, no test for the edge is
    # needed: the cell to the left of the first column is in the closed column of the row above.
    padded = layout.width + 1
    places = layout.open_cells + layout.open_cells // layout.width + padded
    numbers = np.full((layout.height + 2) * padded, -1)
    numbers[places] = np.arange(len(places))
    neighbours = np.stack([numbers[places + step] for step in (-padded, -1, 1, padded)], axis=1)
    starts, sides = np.nonzero(neighbours >= 0)
    return starts, neighbours[starts, sides]
