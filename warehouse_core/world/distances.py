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
    """Return the nearest of ``cells`` by moves, ``[H, W]`` numbers of cells; -1 without a path."""
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
        count = len(layout.open_cells)
        targets, ends = _neighbours(layout)
        graph = csr_array((np.ones(len(targets), np.int8), targets, ends), shape=(count, count))
        sources = layout.ranks(cells)
        lengths, _, source = dijkstra(
            graph, indices=sources, unweighted=True, min_only=True, return_predecessors=True
        )
        moves[layout.open_cells] = lengths
        which[layout.open_cells] = np.where(
            lengths < np.inf, layout.open_cells.take(source, mode="clip"), -1
        )
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
