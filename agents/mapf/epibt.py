"""EPIBT: priority inheritance among robots that choose several actions at once.

It plans for robots with headings, and for others; see ``kernels/operations.py``.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from agents.mapf.graph import CLOSED, Fields, Graph, robots_in
from agents.mapf.headed import HeadedFields, PackedFields
from agents.mapf.kernels.buffers import buffer, buffer_of, prepare
from agents.mapf.kernels.floor import NONE, STAY
from agents.mapf.kernels.operations import CHOSEN, FREE, Crew, crew_of, improve, plan
from agents.mapf.kernels.rounds import NOBODY
from agents.mapf.memory import Memory
from agents.mapf.planner import PlacePlanner, Situation
from warehouse_core.arguments import instance_of, real_number, seed_number, whole_number
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers

__all__ = ["EPIBT"]

MAX_WINDOW = 4
"""Most steps of an operation."""

MAX_TRIES = 100.0
"""Most times that robots choose once more."""


class EPIBT(PlacePlanner):
    """A planner by EPIBT, for robots with and without headings.

    The priority of a robot is the number of steps since it was at a goal of its own; urgent robots
    go before all others. Distances of robots with headings count turns.

    Args:
        graph: floor.
        seed: seed of random tie-breaks.
        window: steps for which each robot chooses its actions, 1 to ``MAX_WINDOW``.
        tries: mean number of times that a robot chooses once more, to lower the sum of all costs,
            0 to ``MAX_TRIES``. That helps where there is room, and takes time.

    Example:
        >>> from agents.mapf.epibt import EPIBT
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> run = run_lifelong(graph, EPIBT(graph), robots=8, steps=50, seed=1, has_headings=True)
        >>> run.reached
        29
    """

    def __init__(self, graph: Graph, seed: int = 0, window: int = 3, tries: float = 0.0) -> None:
        self.graph = instance_of("graph", graph, Graph)
        self.seed = seed_number(seed)
        self.window = whole_number("window", window, 1, MAX_WINDOW)
        self.tries = real_number("tries", tries, 0, MAX_TRIES)
        prepare(plan, improve)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode, and begin again with the random numbers of the seed."""
        super().reset()
        self._outward = outward_cells(self.graph)

    def _choose(self, situation: Situation, places: Integers) -> Integers:
        """Return the next place of each robot, given its present one."""
        cells, goals, stays, closed, urgent = situation
        crew, fields, size = self._crew, self._fields, self.graph.size
        is_closed = self.graph.closed_with(closed)
        rows = fields.rows(np.where(goals == cells, size, goals))  # who is there just gives way
        leaving = self._leaving(rows, cells)
        order = self._memory.order(cells, goals, np.concatenate([urgent, leaving]))
        crew.holder[:] = buffer(self.window * size, NOBODY)
        for kept, new in (
            (crew.places, places), (crew.rows, rows * fields.matrix.shape[1]), (crew.order, order),
            (crew.states, np.where(stays, CHOSEN, FREE)),
            (crew.is_fixed, stays.astype(np.int64)), (crew.robot_in, robots_in(size, cells)),
            (crew.is_closed, is_closed),
        ):  # fmt: skip
            kept[:] = buffer_of(new)
        plan(crew, fields.table)
        if self.tries:
            improve(crew, fields.table, round(self.tries * len(cells)))
        return np.array(crew.ways)[:: self.window]

    def _leaving(self, rows: Integers, cells: Integers) -> Integers:
        """Return the robots in dead ends whose ways lead out, before whom nobody can go in."""
        fields, outward = self._fields, self._outward[cells]
        beyond = fields.nearest(rows, np.where(outward == NONE, cells, outward))
        return np.flatnonzero(beyond < fields.nearest(rows, cells))

    def _begin(self, robots: int, has_headings: bool) -> None:
        """Begin an episode of so many robots."""
        self._fields = PackedFields(self.graph) if has_headings else Fields(self.graph)
        self._memory = Memory(self.graph, np.random.default_rng(self.seed).random(robots))
        self._crew = crew_on(self._fields, self.window, robots, self.seed)


def crew_on(fields: Fields, window: int, robots: int, seed: int | None) -> Crew:
    """Return the buffers of robots that choose their actions for the steps of a window."""
    graph, has_headings = fields.graph, isinstance(fields, HeadedFields)
    beside = graph.neighbours[:, :WAIT]
    ways = turning_operations(window) if has_headings else operations(window)
    columns = fields.columns if isinstance(fields, PackedFields) else None
    return crew_of(
        np.where(beside == CLOSED, NONE, beside), ways, robots, seed, has_headings, columns
    )


def outward_cells(graph: Graph) -> Integers:
    """Return for each cell in a dead end the next on the way out of it, else ``NONE``, ``[size]``.

    A dead end is what is left of a tree of cells, beyond the first cell that has another way.
    """
    beside = graph.neighbours[:, :WAIT]
    degree, outward = (beside != CLOSED).sum(axis=1), np.full(graph.size, NONE)
    ends = np.flatnonzero(degree == 1).tolist()
    while ends:
        cell = ends.pop()
        for out in beside[cell].tolist():
            if degree[cell] == 1 and out != CLOSED and outward[out] == NONE:
                outward[cell], degree[cell] = out, 0
                degree[out] -= 1
                if degree[out] == 1:
                    ends.append(out)
    return outward


def operations(window: int) -> Integers:
    """Return all sequences of moves and waits through a window, the one of waits first."""
    found = sorted(product(range(WAIT + 1), repeat=window), key=lambda each: -each.count(WAIT))
    return np.array(found)


def turning_operations(window: int) -> Integers:
    """Return sequences of moves, turns and waits through a window, the one of waits first.

    The actions are ``FORWARD``, ``RIGHT``, ``LEFT`` and ``STAY``. Of several sequences that lead
    through the same cells to the same heading, the one with the fewest turns is left, and of these
    the one that turns first.
    """
    found: dict[tuple[object, ...], tuple[int, ...]] = {}
    every = product((FORWARD, RIGHT, LEFT, STAY), repeat=window)
    for actions in sorted(every, key=lambda each: (each.count(RIGHT) + each.count(LEFT), each)):
        place, heading, way = 0j, 1 + 0j, list[object]()
        for action in actions:
            heading *= {RIGHT: 1j, LEFT: -1j}.get(action, 1)
            place += heading * (action == FORWARD)
            way.append(place)
        found.setdefault((*way, heading), actions)
    return np.array(sorted(found.values(), key=lambda each: each != (STAY,) * window))
