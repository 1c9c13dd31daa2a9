"""Distance fields for robots with headings, which drive forward and turn on the spot."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, Fields, Graph
from agents.mapf.kernels.buffers import buffer, table_of
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Turning, measure_turning
from warehouse_core.compiled import prepare
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers

SQUARE = 4
"""Side of a square of cells whose distances are close together in memory.

A robot reads the distances ahead and to its sides, which then share fewer cache lines.
"""


class HeadedFields(Fields):
    """Distances between places, where each move and each quarter turn takes a step.

    The actions of ``near`` and ``prices`` are ``FORWARD``, ``RIGHT``, ``LEFT``, one that leads
    nowhere, and waiting.

    Args:
        graph: floor. A turn takes one step, whatever its ``turn_cost`` is.
    """

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.with_costs(graph.costs, 1.0), graph)
        self._leads_back = True
        if graph.costs is None:
            self.step = 1
        rows, columns = np.divmod(graph.layout.open_cells, graph.layout.width)
        self._cells = graph.layout.open_cells[np.lexsort((columns // SQUARE, rows // SQUARE))]
        self._columns = np.zeros(graph.size, np.intp)
        self._columns[self._cells] = np.arange(len(self._cells))
        self._field = np.empty((len(self._cells), WAIT), np.int32)
        prepare(measure_turning)

    @cached_property
    def near(self) -> Integers:
        """Place that each action leads to from each place, ``[places, 5]``, or ``places``."""
        graph, places = self._rounded, np.arange(self._rounded.places).reshape(WAIT, -1)
        result = np.full((*places.shape, ACTIONS), graph.places)
        ahead = graph.neighbours[:, :WAIT].T
        is_shut = (ahead == CLOSED) | np.isin(ahead, list(graph.closed))
        result[..., FORWARD] = np.where(is_shut, graph.places, ahead + places[:, :1])
        result[..., RIGHT], result[..., LEFT] = (
            np.roll(places, -1, axis=0),
            np.roll(places, 1, axis=0),
        )
        result[..., STAY] = places
        return result.reshape(-1, ACTIONS)

    @cached_property
    def prices(self) -> Integers:
        """Costs of the steps of ``near``, ``[places, 5]``."""
        graph = self._rounded
        result = np.full((WAIT, graph.size, ACTIONS), self.step)
        if graph.costs is not None:
            result[..., FORWARD] = np.rint(graph.costs.T * self.step)
        return result.reshape(-1, ACTIONS)

    def _measure(self, goal: int, field: NDArray[np.int32]) -> None:
        """Write the distances of all places from a goal into a field."""
        if self._is_compiled:
            measure_turning(self._turning, int(self._columns[goal]), table_of(self._field))
            field[:] = FAR
            field.reshape(WAIT, -1)[:, self._cells] = self._field.T
        else:
            field[:] = self._distances(goal)

    @cached_property
    def _turning(self) -> Turning:
        """The steps of ``near`` in reverse direction."""
        (here, facing), ahead = self._stands, self.near[:, FORWARD]
        places = self._columns[here] * WAIT + facing
        moves = np.flatnonzero(ahead != self.graph.places)
        behind, price = np.full((2, self._field.size), NONE, np.int32)
        behind[places[ahead[moves]]] = places[moves]
        price[places[ahead[moves]]] = self.prices[moves, FORWARD]
        entries, below = np.empty((2, WAIT * self._field.size), np.int32)
        return Turning(
            turn=self.step, behind=table_of(behind), price=table_of(price),
            heads=buffer(int(self.prices.max()) + 1, NONE), entries=table_of(entries),
            below=table_of(below),
        )  # fmt: skip
