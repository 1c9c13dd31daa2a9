"""The open cells of a layout as a graph, and the distances in it.

Cells are numbered ``row * W + col``, as in the arrays of a fleet. If turns have a cost, distances
are between *places*. A robot in a cell that faces north, east, south or west (0 to 3) is in the
place ``heading * H * W + cell``. Otherwise places are cells.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from agents.mapf.kernels.buffers import Table, buffer, buffer_of, table_of
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY, Places, Reverse, measure
from warehouse_core.arguments import instance_of, real_number
from warehouse_core.compiled import IS_COMPILED, prepare
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.edges import Edges
from warehouse_core.world.layout import Layout
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers

__all__ = ["Graph"]

Costs = NDArray[np.float32]

EAST = 1
"""Initial heading of robots."""

CLOSED = -1
"""Marks a neighbour that is a wall or outside the layout."""

PARTS = 10
"""Units per step in which ``Fields`` counts the costs of lanes and turns."""

MAX_BYTES = 250_000_000
"""Memory for distance fields, beyond which the least recently used ones are dropped.

See also ``waypoints.py``. With it, 10,000 robots on 140 x 500 cells take less than 600 MB in all.
"""

MAX_PRICE = 1_000_000
"""Highest price of a move in ``Fields``, which need a bucket for each price up to the highest."""

QUARTERS = np.array([[0, 1, 2, 1, 0], [1, 0, 1, 2, 0], [2, 1, 0, 1, 0], [1, 2, 1, 0, 0]])
"""Quarter turns from each heading before moving N, E, S or W, or waiting."""

SQUARE = 4
"""Side of squares of cells whose distances are close together in the memory of ``measure``."""


class Graph:
    """The open cells of a layout and the moves between them.

    Args:
        layout: any layout.
        costs: ``[H * W, 4]``, costs above 0 of the moves N, E, S and W from each cell. With
            ``None`` each move costs 1. See ``guidance.py``.
        turn_cost: cost of a quarter turn before a move. A half turn costs twice as much.

    Raises:
        ValueError: ``turn_cost`` is negative or not a number.

    Attributes:
        size: ``H * W``.
        turns: ``[4, 5]`` float32, cost of turning from each heading before moving N, E, S or W, or
            waiting.
        closed: cells that no path may use; see ``close``.
        neighbours: ``[H * W, 5]`` int32, the cell that N, E, S, W and waiting lead to, or
            ``CLOSED``.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from warehouse_core import Layout
        >>> graph = Graph(Layout(["..#", "..."]))
        >>> int(graph.distances(5)[0]), graph.path(0, 5)
        (3, [0, 1, 4, 5])
    """

    def __init__(self, layout: Layout, costs: Costs | None = None, turn_cost: float = 0.0) -> None:
        self.layout, self.costs = instance_of("layout", layout, Layout), costs
        self.turn_cost = real_number("turn_cost", turn_cost, 0.0)
        self.turns = QUARTERS.astype(np.float32) * np.float32(self.turn_cost)
        height, width = layout.height, layout.width
        self.size = height * width
        is_open = np.zeros((height + 2, width + 2), np.bool_)
        rows, columns = layout.places(layout.open_cells).T
        is_open[rows + 1, columns + 1] = True
        self.neighbours = np.full((self.size, WAIT + 1), CLOSED, np.int32)
        for action in range(WAIT + 1):
            down, right = DISPLACEMENTS[action]
            reached = is_open[rows + 1 + down, columns + 1 + right]
            to = (layout.open_cells + down * width + right).astype(np.int32)
            self.neighbours[layout.open_cells[reached], action] = to[reached]
        self.closed: frozenset[int] = frozenset()
        self._fields: dict[int, Costs] = {}

    def with_turns(self, turn_cost: float) -> Graph:
        """Return the graph with a cost of turns, or the graph itself if this cost is 0."""
        turn_cost = real_number("turn_cost", turn_cost)
        return Graph(self.layout, self.costs, turn_cost) if turn_cost else self

    def with_costs(self, costs: Costs | None = None, turn_cost: float = 0.0) -> Graph:
        """Return a graph with the same open and closed cells and other costs of moves."""
        result = Graph(self.layout, costs, turn_cost)
        result.close(self.closed)
        return result

    @property
    def places(self) -> int:
        """Number of places: ``H * W``, or four times as many if turns have a cost."""
        return WAIT * self.size if self.turn_cost else self.size

    def places_at(self, cells: Integers, headings: Integers) -> Integers:
        """Return the places that N, E, S, W and waiting lead to from ``[R]`` places, ``[R, 5]``."""
        near: Integers = self.neighbours[cells]  # CLOSED gives a place that is never used
        if self.turn_cost:
            near = near + self.size * np.arange(WAIT + 1)
            near[:, WAIT] = headings * self.size + cells
        return near

    def headings(self, before: Integers, cells: Integers, headings: Integers) -> Integers:
        """Return the headings of robots after they have moved; all arguments are ``[R]``."""
        moves = self.neighbours[before, :WAIT] == cells[:, None]
        return np.where(moves.any(axis=1), moves.argmax(axis=1), headings)

    def close(self, cells: frozenset[int]) -> None:
        """Close these cells to all paths, and reopen the cells that were closed before."""
        self.closed = cells
        self._fields.clear()
        self.__dict__.pop("_edges", None)

    def closed_with(self, cells: Integers) -> Integers:
        """Return 1 for closed cells and the given cells, 0 for all others, ``[size]``."""
        result = np.zeros(self.size, np.intp)
        result[[*self.closed, *cells.tolist()]] = 1
        return result

    def distances(self, goal: int) -> Costs:
        """Return the cost of the cheapest path from each place to a goal, ``[places]`` float32.

        The cost is infinite for walls and for cells from which the goal is unreachable. Callers
        must not change the field, because it is cached until other fields fill ``MAX_BYTES``.
        """
        field = self._fields.pop(goal, None)
        if field is None:
            goals = range(goal, self.places, self.size)
            field = self._edges.cheapest(goals).astype(np.float32)
        self._fields[goal] = field  # the field that was used last comes last
        if len(self._fields) > max(MAX_BYTES // field.nbytes, 1):
            del self._fields[next(iter(self._fields))]
        return field

    def path(self, cell: int, goal: int) -> list[int]:
        """Return the cells of a cheapest path with both ends, or only the first if none exists.

        The robot initially faces in the direction of the path.
        """
        field, path = self.distances(goal), [cell]
        heading = int(field[cell :: self.size].argmin())
        while np.isfinite(field[cell]) and cell != goal:
            reached = self.neighbours[cell, :WAIT]
            costs = self.turns[heading, :WAIT] + (1 if self.costs is None else self.costs[cell])
            places = self.places_at(np.array([cell]), np.array([heading]))[0, :WAIT]
            is_shut = np.isin(reached, [CLOSED, *self.closed])
            heading = int(np.where(is_shut, np.inf, field[places] + costs).argmin())
            cell = int(reached[heading])
            path.append(cell)
        return path

    @cached_property
    def parts(self) -> Integers:
        """Number of the connected part of each place, ``[places]``, ignoring closed cells."""
        return self._edges.parts()

    @property
    def stands(self) -> tuple[Integers, Integers]:
        """Cell and heading of each place."""
        facing, here = np.divmod(np.arange(self.places), self.size)
        return here, facing

    @cached_property
    def _edges(self) -> Edges:
        """The moves in reverse direction, so that goals are sources."""
        here, facing = self.stands
        is_shut = np.isin(self.neighbours[here, :WAIT], [CLOSED, *self.closed])
        place, action = np.nonzero(~is_shut)
        turns = self.turns[facing[place], action].astype(np.float64)
        costs = turns + (1 if self.costs is None else self.costs[here[place], action])
        return Edges(self.places_at(here, facing)[place, action], place, costs, self.places)


def robots_in(size: int, cells: Integers) -> Integers:
    """Return the robot in each of ``size`` cells, or ``NONE``, given the cells of the robots."""
    result = np.full(size, NONE)
    result[cells] = np.arange(len(cells))
    return result


class Fields:
    """The distance fields of the current goals of many robots, as rows of a matrix.

    Distances are whole numbers of steps. If moves or turns have costs, they are whole numbers of
    tenths of a step, and costs are rounded to tenths. ``FAR`` stands for unreachable goals and for
    longer distances. When all rows together take ``MAX_BYTES``, rows of goals that no robot has are
    reused.

    Args:
        graph: floor.
        followed: graph whose closed cells are closed here too; ``None`` is the floor itself.

    Attributes:
        step: distance of a step without lanes and turns: 1 or ``PARTS``.
        matrix: ``[n, places]`` int32, one row for each goal.
    """

    _moves = WAIT  # actions below this number are moves
    _order: slice | Integers = np.s_[:]  # cells in the order in which kernels number them

    def __init__(self, graph: Graph, followed: Graph | None = None) -> None:
        self.graph, self._followed = graph, followed or graph
        self.step = 1 if graph.costs is None and not graph.turn_cost else PARTS
        self.matrix = np.empty((0, graph.places), np.int32)
        self._row_of = np.full(graph.size, NONE)
        self._free: list[int] = []
        self._used = 0
        self._closed, self._number = graph.closed, np.arange(graph.size)
        self._beside = np.empty((graph.size, graph.places // graph.size), np.int32)
        prepare(measure)

    @property
    def table(self) -> Table:
        """All rows as one flat table for kernels, valid until the next call of ``rows``."""
        return table_of(self.matrix)

    def rows(self, goals: Integers) -> Integers:
        """Return the row of ``matrix`` of each goal, valid until the next call."""
        if self._closed != self._followed.closed:
            self._closed = self._followed.closed
            self._row_of[:] = NONE
            self._free = list(range(self._used))
            for name in ("near", "floor", "_reverse", "_edges"):
                self.__dict__.pop(name, None)
        new = np.unique(goals[self._row_of[goals] == NONE]).tolist()
        if len(new) > len(self._free):
            self._free_rows(goals, len(new))
        for goal in new:
            self._row_of[goal] = row = self._free.pop()
            self._measure(goal, self.matrix[row])
        return self._row_of[goals]

    def distances(self, goals: Integers, places: Integers) -> NDArray[np.int64]:
        """Return the distance of each place from its goal; both arguments have the same length."""
        rows = self.rows(goals)
        return self.matrix[rows, places].astype(np.int64)

    def _measure(self, goal: int, field: NDArray[np.int32]) -> None:
        """Write the distance of each place from a goal into a field, with Numba or else SciPy."""
        if IS_COMPILED:
            measure(self._reverse, int(self._number[goal]), table_of(self._beside))
            field[:] = FAR
            field.reshape(-1, self.graph.size)[:, self._order] = self._beside.T
        else:
            goals = range(goal, self.graph.places, self.graph.size)
            field[:] = np.minimum(self._edges.cheapest(goals), FAR)

    def _steps(self, actions: int) -> tuple[Integers, Integers, Integers]:
        """Return first place, last place and price of each step of ``near`` by these actions."""
        start, action = np.nonzero(self.near[:, :actions] != self.graph.places)
        return start, self.near[start, action], self.prices[start, action]

    @cached_property
    def _edges(self) -> Edges:
        """The steps of ``near`` in reverse direction, so that goals are sources."""
        start, end, price = self._steps(WAIT)
        return Edges(end, start, price.astype(np.float64), self.graph.places)

    @cached_property
    def _reverse(self) -> Reverse:
        """The steps of ``near`` in reverse direction, for kernels."""
        start, end, price = self._steps(self._moves)
        size, (_, headings) = self.graph.size, self._beside.shape
        start, end = (self._number[each % size] * headings + each // size for each in (start, end))
        order = np.argsort(end, kind="stable")
        number = np.arange(len(end)) - np.searchsorted(end[order], end[order])
        behind = np.full((self._beside.size, self._moves, 2), NONE, np.int32)
        behind[end[order], number] = np.stack([start[order], price[order]], axis=1)
        entries = np.empty((WAIT * self._beside.size, 2), np.int32)
        return Reverse(
            headings=headings, turn=self.step if self._moves < WAIT else 0,
            behind=table_of(behind), entries=table_of(entries),
            heads=buffer(int(self.prices.max()) + 1, NONE),
        )  # fmt: skip

    @cached_property
    def near(self) -> Integers:
        """Place that each action leads to from each place, ``[places, 5]``, or ``places``.

        No action leads into a closed cell.
        """
        graph, (here, facing) = self.graph, self.graph.stands
        is_shut = np.isin(graph.neighbours[here], [CLOSED, *self._closed])
        result = np.where(is_shut, graph.places, graph.places_at(here, facing))
        result[:, WAIT] = np.arange(graph.places)
        return result

    @cached_property
    def prices(self) -> Integers:
        """Costs of the steps of ``near``, ``[places, 5]``."""
        here, facing = self.graph.stands
        turn = self._units(self.graph.turn_cost) if self.graph.turn_cost else 0
        result: Integers = self._costs[here] + turn * QUARTERS[facing]
        return result

    @property
    def _costs(self) -> Integers:
        """Costs of the moves N, E, S and W, and of waiting, in each cell, ``[size, 5]``."""
        costs = np.ones((self.graph.size, ACTIONS))
        if self.graph.costs is not None:
            costs[:, :WAIT] = self.graph.costs
        return self._units(costs)

    def _units(self, costs: NDArray[np.floating] | float) -> Integers:
        """Return costs above 0 as whole numbers of ``1 / step``, and at least one of them."""
        result: Integers = np.clip(np.rint(costs * self.step), 1, MAX_PRICE).astype(np.int64)
        return result

    @cached_property
    def floor(self) -> Places:
        """The arrays ``near`` and ``prices`` in the form that kernels use."""
        size, places = self.graph.size, self.graph.places
        ahead = self.near[:size, :WAIT]
        is_open = ahead != places
        degree = is_open.sum(axis=1)
        through = (is_open & (degree[ahead % size] > 1)).sum(axis=1)
        return Places(
            size=size, closed=places, near=buffer_of(self.near), price=buffer_of(self.prices),
            cell=buffer_of(np.arange(places) % size), degree=buffer_of(degree),
            through=buffer_of(through), step=self.step,
        )  # fmt: skip

    def _free_rows(self, goals: Integers, number: int) -> None:
        """Free ``number`` rows: rows of old goals if new rows would exceed ``MAX_BYTES``."""
        most = MAX_BYTES // (self.matrix.shape[1] * self.matrix.itemsize)
        if self._used + number - len(self._free) > most:
            is_old = self._row_of != NONE
            is_old[goals] = False
            self._free += self._row_of[is_old].tolist()
            self._row_of[is_old] = NONE
        used = max(self._used, self._used + number - len(self._free))
        if used > len(self.matrix):
            kept = self.matrix
            rows = used + used // 2
            if 2 * rows > most:  # the last copy is of a small matrix, and takes little memory
                rows = max(used, most)
            self.matrix = np.empty((rows, kept.shape[1]), np.int32)
            self.matrix[: len(kept)] = kept
        self._free += range(self._used, used)
        self._used = used


class HeadedFields(Fields):
    """Distances between places, where each move and each quarter turn takes a step.

    The actions of ``near`` and ``prices`` are ``FORWARD``, ``RIGHT``, ``LEFT``, one that leads
    nowhere, and waiting.

    Args:
        graph: floor. A turn takes one step, whatever its ``turn_cost`` is.
    """

    _moves = FORWARD + 1

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.with_costs(graph.costs, 1.0), graph)
        if graph.costs is None:
            self.step = 1
        rows, columns = np.divmod(graph.layout.open_cells, graph.layout.width)
        cells = graph.layout.open_cells[np.lexsort((columns // SQUARE, rows // SQUARE))]
        self._number[cells] = np.arange(len(cells))
        self._order, self._beside = cells, np.empty((len(cells), WAIT), np.int32)

    @cached_property
    def near(self) -> Integers:
        """Place that each action leads to from each place, ``[places, 5]``, or ``places``."""
        graph, places = self.graph, np.arange(self.graph.places).reshape(WAIT, -1)
        result = np.full((*places.shape, ACTIONS), graph.places)
        ahead = graph.neighbours[:, :WAIT].T
        is_shut = np.isin(ahead, [CLOSED, *self._closed])
        result[..., FORWARD] = np.where(is_shut, graph.places, ahead + places[:, :1])
        result[..., RIGHT] = np.roll(places, -1, axis=0)
        result[..., LEFT] = np.roll(places, 1, axis=0)
        result[..., STAY] = places
        return result.reshape(-1, ACTIONS)

    @cached_property
    def prices(self) -> Integers:
        """Costs of the steps of ``near``, ``[places, 5]``."""
        result = np.full((WAIT, self.graph.size, ACTIONS), self.step)
        result[..., FORWARD] = self._costs[:, :WAIT].T
        return result.reshape(-1, ACTIONS)
