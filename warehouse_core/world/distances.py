"""Distances around walls, from every cell to the nearest of some cells."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.edges import Edges
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Integers
from warehouse_core.world.tiles import Cell

Distances = NDArray[np.float64]
"""``[H, W]`` moves N, E, S or W; infinite for walls and cells without a path."""


def distances(layout: Layout, cells: Collection[Cell]) -> Distances:
    """Return the number of moves from each cell to the nearest of ``cells``, which are open."""
    return _nearest(layout, cells)[0]


def nearest(layout: Layout, cells: Collection[Cell]) -> NDArray[np.intp]:
    """Return the nearest of ``cells`` by moves, ``[H, W]`` numbers of cells; -1 without a path.

    Of cells that are equally near it is the first in row-major order.
    """
    return _nearest(layout, cells)[1]


def _nearest(layout: Layout, cells: Collection[Cell]) -> tuple[Distances, NDArray[np.intp]]:
    """Return for each cell the moves to the nearest of ``cells``, and which one that is."""
    for cell in cells:
        check_open(layout, cell, "cell")
    moves = np.full(layout.height * layout.width, np.inf)
    which = np.full(layout.height * layout.width, -1, np.intp)
    if cells:
        numbers = np.unique(layout.numbers(cells))
        count, scale = len(layout.open_cells), len(numbers) + 1
        starts, ends = _moves(layout)
        # A root leads to the cells with costs 1, 2, ... and a move costs more than these differ:
        # so ties are broken by the order of the cells, not by the version of SciPy.
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
    """Return where the moves between open cells start and end, ``[E]`` each, in order of starts.

    Cells are numbered as in ``open_cells``.
    """
    # A closed column on the right and a closed row above and below make tests for the edge
    # unnecessary: left of the first column is the closed column of the row above.
    padded = layout.width + 1
    places = layout.open_cells + layout.open_cells // layout.width + padded
    numbers = np.full((layout.height + 2) * padded, -1)
    numbers[places] = np.arange(len(places))
    beside = np.stack([numbers[places + step] for step in (-padded, -1, 1, padded)], axis=1)
    starts, sides = np.nonzero(beside >= 0)
    return starts, beside[starts, sides]
