"""Edges with costs between numbered nodes, and the cheapest ways along them.

SciPy finds the ways where it is installed. Where it is not, as in a browser, NumPy finds the same
costs bit for bit, more slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.tables import Integers

if TYPE_CHECKING:  # SciPy is imported where it is used: loading it takes long
    from scipy.sparse import csr_array

Floats = NDArray[np.float64]


class Edges:
    """Directed edges between ``N`` nodes, at most one from each node to each other.

    Args:
        starts: ``[E]`` node that each edge leads from.
        ends: ``[E]`` node that each edge leads to.
        costs: ``[E]`` costs above 0.
        nodes: ``N``.
    """

    def __init__(self, starts: Integers, ends: Integers, costs: Floats, nodes: int) -> None:
        self._starts, self._ends, self._costs, self._nodes = starts, ends, costs, nodes

    def cheapest(self, sources: Sequence[int]) -> Floats:
        """Return the cost of the cheapest way to each node from any of ``sources``, ``[N]``.

        The cost is infinite for nodes that no way leads to.
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
        """Return a number for each node, equal for nodes that edges connect, ``[N]``.

        Every edge has to have one that leads back.
        """
        try:
            from scipy.sparse.csgraph import connected_components
        except ImportError:
            return self._spread(np.arange(self._nodes, dtype=np.float64), 0.0).astype(np.intp)
        found: Integers = connected_components(self._matrix, directed=False)[1]
        return found

    def _spread(self, values: Floats, costs: Floats | float) -> Floats:
        """Lower the values of nodes along the edges until none exceeds a start's and its cost."""
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
