"""Graphs of numbered nodes and edges with costs, and their cheapest paths.

SciPy finds the paths if it is installed. Otherwise, as in a browser, NumPy computes exactly the
same costs, but more slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.tables import Integers

if TYPE_CHECKING:  # SciPy is imported where it is used, because loading it takes long
    from scipy.sparse import csr_array

Floats = NDArray[np.float64]


class Edges:
    """Directed edges between ``N`` nodes, at most one between two nodes in each direction.

    Args:
        starts: ``[E]`` first node of each edge.
        ends: ``[E]`` last node of each edge.
        costs: ``[E]`` cost of each edge, above 0.
        nodes: number of nodes ``N``.
    """

    def __init__(self, starts: Integers, ends: Integers, costs: Floats, nodes: int) -> None:
        self._starts, self._ends, self._costs, self._nodes = starts, ends, costs, nodes

    def cheapest(self, sources: Sequence[int]) -> Floats:
        """Return the cost of the cheapest path to each node from any of ``sources``, ``[N]``.

        The cost of unreachable nodes is infinite.
        """
        try:
            from scipy.sparse.csgraph import dijkstra
        except ImportError:
            found = np.full(self._nodes, np.inf)
            found[np.asarray(sources)] = 0.0
            return self._spread(found, self._costs)
        costs: Floats = dijkstra(self._matrix, indices=sources, min_only=True)
        return costs

    def parts(self) -> Integers:
        """Return the number of the connected component of each node, ``[N]``.

        Every edge must have an edge in the other direction.
        """
        try:
            from scipy.sparse.csgraph import connected_components
        except ImportError:
            return self._spread(np.arange(self._nodes, dtype=np.float64), 0.0).astype(np.intp)
        found: Integers = connected_components(self._matrix, directed=False)[1]
        return found

    def _spread(self, values: Floats, costs: Floats | float) -> Floats:
        """Lower the values until no edge's end exceeds its start by more than the edge's cost."""
        costs = np.broadcast_to(costs, self._starts.shape)
        active = np.arange(len(self._starts))
        while len(active):
            ends = self._ends[active]
            reached = values[self._starts[active]] + costs[active]
            before = values.copy()
            np.minimum.at(values, ends, reached)
            active = np.flatnonzero((values < before)[self._starts])
        return values

    @cached_property
    def _matrix(self) -> csr_array:
        from scipy.sparse import csr_array

        shape = self._nodes, self._nodes
        return csr_array((self._costs, (self._starts, self._ends)), shape=shape)
