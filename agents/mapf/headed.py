"""Distance fields of robots with headings, which drive forward and turn on the spot."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, Fields, Graph
from agents.mapf.kernels.buffers import IS_COMPILED, Buffer, buffer, prepare, table_of
from agents.mapf.kernels.floor import ACTIONS, FAR, NONE, STAY, count_steps
from agents.mapf.kernels.packed import BASE, ENTRIES, PACKED_FAR, Way, measure_packed, pack
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers

SQUARE = 4
"""Cells across a square of cells whose distances ``PackedFields`` keeps beside one another.

A robot asks for distances ahead and to its sides, which are in fewer lines of the cache so.
"""


class HeadedFields(Fields):
    """Distances between places of which each move and each quarter turn is a step.

    The actions of ``near`` and ``prices`` are ``FORWARD``, ``RIGHT``, ``LEFT``, one that leads
    nowhere, and waiting.

    Args:
        graph: floor; turns take a step each, whatever its ``turn_cost`` is.
    """

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.with_costs(graph.costs, 1.0))
        self._leads_back = True
        if graph.costs is None:
            self.step = 1
            prepare(count_steps)

    @cached_property
    def near(self) -> Integers:
        """Place that each action leads to from each place, ``[places, 5]``, or ``places``."""
        graph, places = self._rounded, np.arange(self._rounded.places).reshape(WAIT, -1)
        found = np.full((*places.shape, ACTIONS), graph.places)
        ahead = graph.neighbours[:, :WAIT].T
        is_shut = (ahead == CLOSED) | np.isin(ahead, list(graph.closed))
        found[..., FORWARD] = np.where(is_shut, graph.places, ahead + places[:, :1])
        found[..., RIGHT], found[..., LEFT] = (
            np.roll(places, -1, axis=0),
            np.roll(places, 1, axis=0),
        )
        found[..., STAY] = places
        return found.reshape(-1, ACTIONS)

    @cached_property
    def prices(self) -> Integers:
        """Costs of the steps of ``near``, ``[places, 5]``."""
        graph = self._rounded
        found = np.full((WAIT, graph.size, ACTIONS), self.step)
        if graph.costs is not None:
            found[..., FORWARD] = np.rint(graph.costs.T * self.step)
        return found.reshape(-1, ACTIONS)

    def _measure(self, goal: int, field: NDArray[np.int32]) -> None:
        """Write the distances of all places from a goal into a field."""
        if IS_COMPILED and self.step == 1 and not self._closed:
            field[:] = FAR
            count_steps(table_of(self.graph.neighbours), goal, table_of(field), *self._spare)
        else:
            super()._measure(goal, field)

    @cached_property
    def _spare(self) -> tuple[Buffer, Buffer, Buffer]:
        """Buffers that ``count_steps`` uses."""
        size = self.graph.size
        return buffer(size), buffer(size), buffer(WAIT * size)


class PackedFields(HeadedFields):
    """Distances between places, of which each open cell has the four in one number.

    That is a quarter of the memory or less. Ways of ``PACKED_FAR`` and more count as none; see
    ``kernels/packed.py``.

    Attributes:
        matrix: ``[n, open cells]`` int32, a row for each goal, square by square.
        columns: ``[size]``, column of each open cell.
    """

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph)
        rows, columns = np.divmod(graph.layout.open_cells, graph.layout.width)
        squares = np.lexsort((columns // SQUARE, rows // SQUARE))
        self._cells = graph.layout.open_cells[squares]
        self.columns = np.zeros(graph.size, np.intp)
        self.columns[self._cells] = np.arange(len(self._cells))
        self.matrix = np.empty((0, len(self._cells)), np.int32)
        self._field = np.empty(WAIT * len(self._cells), np.int32)
        prepare(measure_packed, pack)

    def nearest(self, rows: Integers, cells: Integers) -> Integers:
        """Return the distance of each cell from the goal of a row, by the best heading."""
        found: Integers = (self.matrix[rows, self.columns[cells]] >> BASE) & PACKED_FAR
        return found

    def _measure(self, goal: int, field: NDArray[np.int32]) -> None:
        """Write the numbers of all open cells into a field."""
        if self._is_compiled:
            places = table_of(self._field), table_of(field)
            measure_packed(self._way, int(self.columns[goal]), self._heads, *places)
            return
        distances = self._distances(goal).reshape(WAIT, -1)
        self._field[:] = distances[:, self._cells].T.ravel()
        pack(table_of(self._field), table_of(field))

    @cached_property
    def _heads(self) -> Buffer:
        return buffer(int(self.prices.max()) + 1, NONE)

    @cached_property
    def _way(self) -> Way:
        """The steps of ``near``, from where they lead, for ``measure_packed``."""
        (here, facing), ahead = self._stands, self.near[:, FORWARD]
        places = self.columns[here] * WAIT + facing
        moves = np.flatnonzero(ahead != self.graph.places)
        behind, price = np.full((2, len(self._field)), NONE, np.int32)
        behind[places[ahead[moves]]] = places[moves]
        price[places[ahead[moves]]] = self.prices[moves, FORWARD]
        room = np.empty((2, (ENTRIES + 1) * len(self._field)), np.int32)
        return Way(self.step, *map(table_of, (behind, price, *room)))
