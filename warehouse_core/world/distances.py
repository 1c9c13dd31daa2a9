"""Distances around walls, from every cell to the nearest of some cells."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.layout import Layout, check_open
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
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    for cell in cells:
        check_open(layout, cell, "cell")
    moves = np.full(layout.height * layout.width, np.inf)
    which = np.full(layout.height * layout.width, -1, np.intp)
    if cells:
        numbers = np.unique(layout.numbers(cells))
        count, scale = len(layout.open_cells), len(numbers) + 1
        targets, ends = _neighbours(layout)
        # A root leads to the cells with costs 1, 2, ... and a move costs more than these differ:
        # so ties are broken by the order of the cells, not by the version of SciPy.
        costs = np.append(np.full(len(targets), scale), np.arange(1, scale)).astype(np.float64)
        targets = np.append(targets, np.searchsorted(layout.open_cells, numbers))
        ends = np.append(ends, len(targets))
        graph = csr_array((costs, targets, ends), shape=(count + 1, count + 1))
        lengths = dijkstra(graph, indices=count)[:count]
        reached = np.isfinite(lengths)
        steps, source = np.divmod(lengths[reached], scale)
        moves[layout.open_cells[reached]] = steps
        which[layout.open_cells[reached]] = numbers[source.astype(np.intp) - 1]
    shape = layout.height, layout.width
    return moves.reshape(shape), which.reshape(shape)


def _neighbours(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the open neighbours of all open cells, as the indices and index pointer of CSR.

    Cells are numbered as in ``open_cells``, ``[O]``. The first array holds the neighbours of cell
    ``i`` from ``ends[i]`` to ``ends[i + 1]``; ``ends`` is ``[O + 1]`` and starts with 0.
    """
    # A closed column on the right and a closed row above and below make tests for the edge
    # unnecessary: left of the first column is the closed column of the row above.
    padded = layout.width + 1
    places = layout.open_cells + layout.open_cells // layout.width + padded
    numbers = np.full((layout.height + 2) * padded, -1, dtype=np.int32)
    numbers[places] = np.arange(len(places), dtype=np.int32)
    beside = np.stack([numbers[places + step] for step in (-padded, -1, 1, padded)], axis=1)
    is_open = beside >= 0
    ends = np.zeros(len(places) + 1, dtype=np.int32)
    np.cumsum(is_open.sum(axis=1), out=ends[1:])
    return beside[is_open], ends
