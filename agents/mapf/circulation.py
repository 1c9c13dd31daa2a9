"""Circulation: a planner that chooses the moves of all robots together, for very dense floors.

See ``kernels/auction.py`` for the algorithm and its sources.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, Fields, Graph, HeadedFields, robots_in
from agents.mapf.kernels.auction import MAX_DISTANCE, PARTS, WORTH, Auction, choose
from agents.mapf.kernels.buffers import buffer, buffer_of, table_of, write
from agents.mapf.kernels.places import ACTIONS, FAR, NONE, STAY
from agents.mapf.kernels.robots import NOBODY, UNDECIDED, robots_of
from agents.mapf.planner import Memory, PlacePlanner, Situation
from warehouse_core.arguments import instance_of, seed_number
from warehouse_core.compiled import prepare
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

__all__ = ["Circulation"]

PATIENCE = 200
"""Steps without a goal after which a robot's weight has doubled; it continues to grow like this."""

MOST_PATIENCES = 100
"""Limit on the weight of a robot in units of patience, which bounds the time of an auction."""

URGENCY = 8
"""Factor on the gains of urgent robots."""


class Circulation(PlacePlanner):
    """Planner that moves robots, with or without headings, in circulations, step by step.

    Args:
        graph: floor. With lanes as costs, robots reach more goals; see ``guidance.py``.
        seed: seed of random tie-breaks.

    Example:
        >>> from agents.mapf.circulation import Circulation
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> planner = Circulation(graph)
        >>> run = run_lifelong(graph, planner, robots=76, steps=50, seed=1, has_headings=True)
        >>> run.reached
        33
    """

    def __init__(self, graph: Graph, seed: int = 0) -> None:
        self.graph = instance_of("graph", graph, Graph)
        self.seed = seed_number(seed)
        prepare(choose)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode, and restart the random numbers from the seed."""
        super().reset()
        self._outward = dead_ends(self.graph)

    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        places = situation.cells if places is None else places
        self._read(situation, places)
        self._robots.random[0] = int(self._random.integers(1, 2**31))
        choose(self._robots, self._auction, self.fields.table)
        self._places, self._aims = (
            np.array(each, places.dtype) for each in (self._robots.places, self._auction.targets)
        )
        return self._places.copy()

    def _begin(self, robots: int, has_headings: bool) -> None:
        graph = self.graph
        flat = graph.with_costs(graph.costs) if graph.turn_cost else graph
        self.fields = HeadedFields(graph) if has_headings else Fields(flat, graph)
        self._random = np.random.default_rng(self.seed)
        self._memory = Memory(graph, self._random.random(robots))
        self._robots = robots_of(graph.size, robots, self.seed)
        self._auction = auction_on(self.fields, robots, PATIENCE)
        self._places, self._aims = np.full((2, robots), NONE)

    def _read(self, situation: Situation, places: Integers) -> None:
        """Load a situation into the buffers: robots, their moves, goals and weights."""
        cells, goals, stays, closed, urgent, _ = situation
        self._memory.order(cells, goals, urgent)
        weights = np.minimum(PATIENCE + self._memory.ages, MOST_PATIENCES * PATIENCE)
        weights[urgent] *= URGENCY
        rows, robots, auction = self.fields.rows(goals), self._robots, self._auction
        is_closed = self.graph.closed_with(closed)
        aims = np.where(
            (places == self._places) & ~stays & (is_closed[self._aims] == 0), self._aims, NONE
        )
        rests = (goals == cells) | (self.fields.matrix[rows, places] >= FAR)
        rests |= waits_for_exits(self._outward, cells, goals)
        write(
            robots, places=places, goals=np.where(rests, cells, goals),
            rows=rows * self.fields.matrix.shape[1], chosen=np.where(stays, places, UNDECIDED),
            robot_in=robots_in(self.graph.size, cells), is_closed=is_closed,
        )  # fmt: skip
        targets = kept_aims(self.graph.size, cells, aims)
        write(auction, targets=targets, is_there=rests, weights=weights,
              actions=np.full(len(cells), STAY))  # fmt: skip


def auction_on(fields: Fields, robots: int, unit: int) -> Auction:
    """Return the buffers of an auction on a floor for robots of weight 1; see ``Auction``."""
    graph, step = fields.graph, fields.step
    size, neighbours = graph.size, graph.neighbours[:, :WAIT]
    if graph.costs is not None:  # so that even the cheapest move has a gain
        step = max(1, int(graph.costs[neighbours != CLOSED].min(initial=1.0) * step))
    worth = WORTH * np.log2(np.arange(MAX_DISTANCE * PARTS + 1) / PARTS + 1)
    return Auction(
        step=step, has_headings=int(isinstance(fields, HeadedFields)), unit=unit,
        ahead=table_of(neighbours.copy()), worth=buffer_of(np.rint(worth).astype(np.int64)),
        targets=buffer(robots, NONE), is_there=buffer(robots), weights=buffer(robots, unit),
        is_claimed=buffer(size), options=buffer(robots * ACTIONS, NONE),
        gains=buffer(robots * ACTIONS), actions=buffer(robots, STAY), wanted=buffer(robots, NONE),
        moves=buffer(robots), prices=buffer(size), holder=buffer(size, NOBODY),
    )  # fmt: skip


def kept_aims(size: int, cells: Integers, aims: Integers) -> Integers:
    """Return the cells to which robots have moves, without permanently blocked ones, ``[R]``."""
    robot_in, aims = robots_in(size, cells), aims.copy()
    while True:
        before = robot_in[aims]
        is_blocked = (aims != NONE) & (before != NOBODY) & (aims[before] == NONE)
        if not is_blocked.any():
            return aims
        aims[is_blocked] = NONE


def dead_ends(graph: Graph) -> Integers:
    """Return for each cell in a dead end the next cell on the way out, else ``NONE``, ``[size]``.

    Dead ends are found by removing cells with one neighbour repeatedly. A dead end reaches up to
    the first cell that has another exit. Dead ends that lead only into one another do not count.
    """
    neighbours = graph.neighbours[:, :WAIT]
    degree, outward = (neighbours != CLOSED).sum(axis=1), np.full(graph.size, NONE)
    ends = np.flatnonzero(degree == 1).tolist()
    while ends:
        cell = ends.pop()
        for out in neighbours[cell].tolist():
            if degree[cell] == 1 and out != CLOSED and outward[out] == NONE:
                outward[cell], degree[cell] = out, 0
                degree[out] -= 1
                if degree[out] == 1:
                    ends.append(out)
    mouths = np.where(outward == NONE, np.arange(len(outward)), outward)
    while (outward[mouths] != NONE).any():
        mouths = mouths[mouths]
    is_on_cycle = ((neighbours != CLOSED) & (outward[neighbours] == NONE)).any(axis=1)
    return np.where(is_on_cycle[mouths], outward, NONE)


def waits_for_exits(outward: Integers, cells: Integers, goals: Integers) -> NDArray[np.bool_]:
    """Return whether each robot waits until others have left the dead end of its goal, ``[R]``.

    A robot that waits at the mouth of a dead end, or enters it, would keep the others from coming
    out. It therefore has no goal, and gives way, while robots with other goals are between it and
    its goal. ``outward`` comes from ``dead_ends``.
    """
    robot_in, waits = robots_in(len(outward), cells), np.zeros(len(cells), np.bool_)
    goes = goals != cells
    for robot in np.flatnonzero(goes & (outward[goals] != NONE)).tolist():
        cell, is_met = int(goals[robot]), False
        while outward[cell] != NONE and cell != cells[robot]:
            is_met |= robot_in[cell] != NOBODY and bool(goes[robot_in[cell]])
            cell = int(outward[cell])
        waits[robot] = is_met and (cell == cells[robot] or outward[cells[robot]] == NONE)
    return waits
