"""The open cells of a layout as a graph, and the distances in it.

Cells are numbers, ``row * W + col``, as in the arrays of a fleet.
"""

from __future__ import annotations

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.layout import Layout

Integers = NDArray[np.integer]
Costs = NDArray[np.float32]

MOVES = range(WAIT)
"""The actions that move a robot: N, E, S, W."""

CLOSED = -1
"""In place of a neighbour that is a wall or off the layout."""

MAX_BYTES = 1_000_000_000
"""Of the distance fields that are kept."""


class Graph:
    """The open cells of a layout and the moves between them.

    Args:
        layout: any.
        costs: ``[H * W, 4]`` of the moves N, E, S and W from each cell, above 0; ``None`` is 1
            each. See ``lanes.py``.

    Attributes:
        layout: as given.
        costs: as given.
        size: ``H * W``.
        neighbours: ``[H * W, 5]`` int32, the cell that N, E, S, W and waiting lead to, or
            ``CLOSED``.
    """

    def __init__(self, layout: Layout, costs: Costs | None = None) -> None:
        self.layout, self.costs = layout, costs
        height, width = layout.height, layout.width
        self.size = height * width
        is_open = np.zeros((height + 2, width + 2), np.bool_)
        rows, columns = np.divmod(layout.open_cells, width)
        is_open[rows + 1, columns + 1] = True
        self.neighbours = np.full((self.size, WAIT + 1), CLOSED, np.int32)
        for action in range(WAIT + 1):
            down, right = DISPLACEMENTS[action]
            reached = is_open[rows + 1 + down, columns + 1 + right]
            to = (layout.open_cells + down * width + right).astype(np.int32)
            self.neighbours[layout.open_cells[reached], action] = to[reached]
        self._fields: OrderedDict[int, Costs] = OrderedDict()
        self._edges = self._reversed_edges()

    def distances(self, goal: int) -> Costs:
        """Return the cost of the cheapest way from each cell to a goal, ``[H * W]`` float32.

        It is infinite for walls and cells without a way. Fields are kept, those used last, in
        ``MAX_BYTES``; they are not to be changed.
        """
        field = self._fields.get(goal)
        if field is None:
            field = dijkstra(self._edges, indices=goal, unweighted=self.costs is None)
            field = self._fields[goal] = field.astype(np.float32)
            while len(self._fields) > max(MAX_BYTES // field.nbytes, 1):
                self._fields.popitem(last=False)
        else:
            self._fields.move_to_end(goal)
        return field

    def _reversed_edges(self) -> csr_array:
        """Return the moves from where they lead to where they start, so that goals are sources."""
        start, action = np.nonzero(self.neighbours[:, :WAIT] != CLOSED)
        end = self.neighbours[start, action]
        costs = np.ones(len(start)) if self.costs is None else self.costs[start, action]
        return csr_array((costs, (end, start)), shape=(self.size, self.size))
