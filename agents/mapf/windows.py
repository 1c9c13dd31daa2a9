"""Lifelong planning in windows: a plan of the next steps that is always free of conflicts.

In each step the plan of the last is continued by a round of PIBT, or replaced by fresh rounds if
these are better, and then refined group by group; see ``kernels/groups.py``. Next goals are not
known: a robot that has arrived gives way.

Sources: Li et al. (2021), Lifelong multi-agent path finding in large-scale warehouses, AAAI: the
rolling horizon. Li et al. (2021), Anytime multi-agent path finding via large neighborhood search,
IJCAI: groups that are planned anew.
"""

from __future__ import annotations

from math import inf
from time import perf_counter

import numpy as np

from agents.mapf.graph import EAST, Fields, Graph
from agents.mapf.kernels.buffers import buffer_of, prepare
from agents.mapf.kernels.groups import improve, new_groups
from agents.mapf.kernels.rollouts import prices, roll
from agents.mapf.kernels.rounds import team_of
from agents.mapf.kernels.ways import NONE, new_frontier, new_ways
from agents.mapf.planner import Situation
from warehouse_core.arguments import instance_of, real_number, seed_number, whole_number
from warehouse_core.world.tables import Integers

WINDOW = 15
"""Default steps that are planned ahead."""

GROUPS = 40
"""Default groups of robots that are planned anew in a step."""

CLOSED_STEPS = 5
"""Steps for which closed cells are expected to stay closed."""

PORTION = 10
"""Groups between two looks at the clock."""

MAX_WINDOW = 10_000
"""Limit on the steps of a window, each of which takes memory for all cells."""


class WindowedPlanner:
    """Plans the next steps of all robots, refines the plan, and takes the first step.

    Args:
        graph: floor; with lanes as costs more robots reach their goals, see ``lanes.py``.
        window: steps that are planned ahead.
        groups: groups of robots that are planned anew in each step, and kept if better.
        seconds: time in each step after which no more groups are planned anew.
        seed: seed of the order in groups.
        turn_cost: see ``PIBT``.

    Attributes:
        fresh: steps since ``reset`` whose plan was made anew.
    """

    def __init__(
        self,
        graph: Graph,
        window: int = WINDOW,
        groups: int = GROUPS,
        seconds: float = inf,
        seed: int = 0,
        turn_cost: float = 0.0,
    ) -> None:
        self.window = whole_number("window", window, 2, MAX_WINDOW)
        self.groups, self.seed = whole_number("groups", groups, 0), seed_number(seed)
        self.seconds = real_number("seconds", seconds, finite=False)
        self.graph = graph = instance_of("graph", graph, Graph).with_turns(turn_cost)
        self._fields = Fields(graph)
        prepare(roll, prices, improve)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self.fresh = 0
        self._ages: Integers = np.empty(0, np.intp)

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step; see ``Planner``."""
        deadline = perf_counter() + self.seconds
        if len(situation.cells) != len(self._ages):
            self._begin(len(situation.cells))
        self._read(situation)
        self._continue(situation)
        self._refine(situation.closed, deadline)
        self._expected = self._places[:, 1].copy()
        return (self._expected % self.graph.size).astype(situation.cells.dtype)

    def plan_of(self, robot: int) -> list[int]:
        """Return the cells of a robot from the end of the step just chosen on; see ``Planner``."""
        found: list[int] = (self._places[robot, 1:] % self.graph.size).tolist()
        return found

    def _begin(self, robots: int) -> None:
        """Make the buffers for so many robots."""
        floor, times = self._fields.floor, self.window + 1
        self._team = team_of(self.graph.size, robots, self.seed)
        self._ways = new_ways(floor, robots, times, True)
        self._frontier = new_frontier(floor, self._ways)
        self._groups = new_groups(robots, times, self.seed)
        self._ages = np.zeros(robots, np.intp)
        self._ranks = np.random.default_rng(self.seed).permutation(robots) / robots
        self._places = np.asarray(self._ways.places).reshape(robots, times)
        self._places[:] = NONE
        self._expected = self._places[:, 0]
        self._cells, self._headings = np.full(robots, NONE), np.full(robots, EAST)

    def _read(self, situation: Situation) -> None:
        """Take over a situation: robots, goals and priorities."""
        graph, cells, goals = self.graph, situation.cells, situation.goals
        self._here = cells
        if graph.turn_cost:
            known = self._cells != NONE
            turned = graph.headings(np.where(known, self._cells, cells), cells, self._headings)
            self._headings, self._cells = turned, cells.copy()
            self._here = turned * graph.size + cells
        rows = self._fields.rows(goals) * graph.places
        self._table = self._fields.table
        self._ages = np.where(cells == goals, 0, self._ages + 1)
        priorities = self._ages + self._ranks
        priorities[situation.urgent] += self._ages.max(initial=0) + 1
        self._order = buffer_of(np.argsort(-priorities, kind="stable"))
        for buffers in (self._team, self._ways):
            buffers.goals[:], buffers.rows[:] = buffer_of(goals), buffer_of(rows)
        self._ways.stays[:] = buffer_of(situation.stays.astype(np.intp))

    def _continue(self, situation: Situation) -> None:
        """Continue the last plan, or make a new one if that is better."""
        floor, ways, team, table = self._fields.floor, self._ways, self._team, self._table
        closed, last, places = buffer_of(situation.closed), self.window, self._places
        holds = self._holds(situation)
        if holds:
            places[:, :-1] = places[:, 1:]
            team.order[:] = self._order
            roll(floor, ways, team, table, closed, last - 1, last)
            shifted = places.copy()
        self.fresh += not holds
        places[:, 0] = self._here
        team.order[:] = self._order
        roll(floor, ways, team, table, closed, 0, last)
        cost = prices(floor, ways, table)
        if holds:
            fresh = places.copy()
            places[:] = shifted
            if prices(floor, ways, table) > cost:
                places[:] = fresh
                prices(floor, ways, table)

    def _holds(self, situation: Situation) -> bool:
        """Return whether the plan goes on where the robots are, and its next step can be taken."""
        there = self._places[:, 2]
        moves = there != self._here
        enters = np.isin(there % self.graph.size, situation.closed)
        lasts = (self._expected == self._here) & ~(moves & (situation.stays | enters))
        return bool(lasts.all())

    def _refine(self, closed: Integers, deadline: float) -> None:
        """Plan groups anew until they or the time are over."""
        floor, ways, size = self._fields.floor, self._ways, self.graph.size
        robots, times = self._places.shape
        reserved = np.asarray(ways.reserved).reshape(times, size)
        reserved[:] = 0
        reserved[1 : 1 + CLOSED_STEPS, closed] = robots + 1
        reserved[np.arange(times), self._places % size] = np.arange(1, robots + 1)[:, None]
        left = self.groups
        while left > 0 and perf_counter() < deadline:
            trials = min(left, PORTION)
            improve(floor, ways, self._frontier, self._groups, self._table, trials)
            left -= trials
