"""How far it is from every cell to the nearest of some, round the walls."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tiles import Cell

Distances = NDArray[np.float64]
"""``[H, W]`` moves to N, E, S and W; infinite where no way leads, and in walls."""


def distances(layout: Layout, cells: Collection[Cell]) -> Distances:
    """Return the moves from each cell to the nearest of some.

    Raises:
        LayoutError: one of these is not open.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    for cell in cells:
        check_open(layout, cell, "cell")
    found = np.full(layout.height * layout.width, np.inf)
    if cells:
        count = len(layout.open_cells)
        targets, ends = _neighbours(layout)
        graph = csr_array((np.ones(len(targets), np.int8), targets, ends), shape=(count, count))
        flat = [row * layout.width + col for row, col in cells]
        sources = np.searchsorted(layout.open_cells, flat)
        found[layout.open_cells] = dijkstra(graph, indices=sources, unweighted=True, min_only=True)
    return found.reshape(layout.height, layout.width)


def _neighbours(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the open neighbours of all open cells, and where in them those of each cell end.

    Cells are numbered as in ``open_cells``, ``[O]``. The first array holds the neighbours of cell
    ``i`` from ``ends[i]`` to ``ends[i + 1]``; ``ends`` is ``[O + 1]`` and starts with 0.
    """
    # A closed column at the right and a closed row above and below spare all tests for the edge:
    # what would be left of the first column is the closed one of the row above.
    padded = layout.width + 1
    places = layout.open_cells + layout.open_cells // layout.width + padded
    numbers = np.full((layout.height + 2) * padded, -1, dtype=np.int32)
    numbers[places] = np.arange(len(places), dtype=np.int32)
    beside = np.stack([numbers[places + step] for step in (-padded, -1, 1, padded)], axis=1)
    is_open = beside >= 0
    ends = np.zeros(len(places) + 1, dtype=np.int32)
    np.cumsum(is_open.sum(axis=1), out=ends[1:])
    return beside[is_open], ends
