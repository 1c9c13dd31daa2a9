"""The open cells of a layout as a graph, and the distances in it.

Cells are numbers, ``row * W + col``, as in the arrays of a fleet.
"""

from __future__ import annotations

from collections import OrderedDict
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.layout import Layout

if TYPE_CHECKING:  # SciPy is imported where it is used: loading it takes long
    from scipy.sparse import csr_array

Integers = NDArray[np.integer]
Costs = NDArray[np.float32]

MOVES = range(WAIT)
"""The actions that move a robot: N, E, S, W."""

CLOSED = -1
"""In place of a neighbour that is a wall or off the layout."""

MAX_BYTES = 1_000_000_000
"""Of the distance fields that are kept."""

FAR = np.iinfo(np.uint16).max
"""Where no way leads to the goal, in ``Fields``."""

NO_ROW = -1


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

    def distances(self, goal: int, keep: bool = True) -> Costs:
        """Return the cost of the cheapest way from each cell to a goal, ``[H * W]`` float32.

        It is infinite for walls and cells without a way. Fields are kept, those used last, in
        ``MAX_BYTES``; they are not to be changed.

        Args:
            goal: a cell.
            keep: whether to keep the field if it was not kept yet.
        """
        field = self._fields.get(goal)
        if field is None:
            from scipy.sparse.csgraph import dijkstra

            found = dijkstra(self._edges, indices=goal, unweighted=self.costs is None)
            field = np.asarray(found, np.float32)
            if not keep:
                return field
            self._fields[goal] = field
            while len(self._fields) > max(MAX_BYTES // field.nbytes, 1):
                self._fields.popitem(last=False)
        else:
            self._fields.move_to_end(goal)
        return field

    def way(self, cell: int, goal: int) -> list[int]:
        """Return the cells of a cheapest way, both ends included; only the first if there is none.

        Args:
            cell: where it starts.
            goal: another cell, or the same.
        """
        field, way = self.distances(goal), [cell]
        while np.isfinite(field[cell]) and cell != goal:
            reached = self.neighbours[cell, :WAIT]
            costs = np.ones(WAIT) if self.costs is None else self.costs[cell]
            cell = int(
                reached[np.where(reached == CLOSED, np.inf, field[reached] + costs).argmin()]
            )
            way.append(cell)
        return way

    @cached_property
    def _edges(self) -> csr_array:
        """Return the moves from where they lead to where they start, so that goals are sources."""
        from scipy.sparse import csr_array

        start, action = np.nonzero(self.neighbours[:, :WAIT] != CLOSED)
        end = self.neighbours[start, action]
        costs = np.ones(len(start)) if self.costs is None else self.costs[start, action]
        return csr_array((costs, (end, start)), shape=(self.size, self.size))


class Fields:
    """The distance fields of the goals that many robots have now, as rows of a matrix.

    The rows are uint16 as long as all distances are whole numbers below ``FAR``, which stands for
    infinite, and float32 from then on. Once they take ``MAX_BYTES``, rows of goals that nobody has
    are used again.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.matrix: NDArray[np.uint16 | np.float32] = np.empty((0, graph.size), np.uint16)
        self._row_of = np.full(graph.size, NO_ROW)
        self._free: list[int] = []

    def rows(self, goals: Integers) -> Integers:
        """Return the row of ``matrix`` of each goal; it holds until the next call."""
        for goal in np.unique(goals[self._row_of[goals] == NO_ROW]).tolist():
            if not self._free:
                self._free_rows(goals)
            self._row_of[goal] = row = self._free.pop()
            self._fill(row, self.graph.distances(goal, keep=False))
        found: Integers = self._row_of[goals]
        return found

    def _free_rows(self, goals: Integers) -> None:
        rows = len(self.matrix)
        if self.matrix.nbytes >= MAX_BYTES:
            is_old = self._row_of != NO_ROW
            is_old[goals] = False
            self._free = self._row_of[is_old].tolist()
            self._row_of[is_old] = NO_ROW
        if not self._free:
            more = max(rows // 2, 64)
            self.matrix.resize((rows + more, self.graph.size), refcheck=False)
            self._free = list(range(rows, rows + more))

    def _fill(self, row: int, field: Costs) -> None:
        field = np.where(np.isinf(field), FAR, field)
        if self.matrix.dtype == np.uint16 and ((field % 1 != 0) | (field > FAR)).any():
            self.matrix = self.matrix.astype(np.float32)
        self.matrix[row] = field
