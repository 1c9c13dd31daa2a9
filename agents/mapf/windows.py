"""Rolling horizon: lifelong planning in windows, with plans that are always free of conflicts.

In each step, the plan of the previous step is continued, and LNS then improves it; see
``kernels/lns.py``. In every fifth step, new plans are made with rounds of PIBT (of EPIBT for robots
with headings) and with circulations, and the cheapest plan is kept; see
``kernels/rolling_horizon.py``. The next goals are unknown, so a robot that has reached its goal
gives way.

Sources: Li et al. (2021), Lifelong multi-agent path finding in large-scale warehouses, AAAI, for
the rolling horizon. Li et al. (2021), Anytime multi-agent path finding via large neighborhood
search, IJCAI, for the improvement.
"""

from __future__ import annotations

from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from agents.mapf.circulation import auction_on
from agents.mapf.graph import Fields, Graph, HeadedFields, robots_in
from agents.mapf.kernels.buffers import buffer_of, write
from agents.mapf.kernels.epibt import epibt_of
from agents.mapf.kernels.lns import PORTION, improve, improve_until, new_groups, renew
from agents.mapf.kernels.pibt import pibt_of
from agents.mapf.kernels.places import FAR, NONE
from agents.mapf.kernels.robots import robots_of
from agents.mapf.kernels.rolling_horizon import roll_circulation, roll_epibt, roll_pibt, write_costs
from agents.mapf.kernels.space_time_astar import (
    CLOSED_STEPS,
    find_route,
    new_frontier,
    new_routes,
    reserve,
    reserve_only,
)
from agents.mapf.planner import Memory, PlacePlanner, Situation
from warehouse_core.arguments import instance_of, real_number, seed_number, whole_number
from warehouse_core.compiled import prepare
from warehouse_core.world.actions import WAIT
from warehouse_core.world.tables import Integers

__all__ = ["WindowedPlanner"]

WINDOW = 15
"""Default number of steps that are planned ahead."""

LEAST_GROUPS, MOST_GROUPS = 20, 400
"""Limits on the default number of groups that are replanned in a step, one for each robot.

On 32 x 32 cells with 400 robots, 20, 100 and 400 groups reached 9.6, 10.9 and 12.1 goals per step.
"""

FRESH = 5
"""Number of steps after which a new plan may replace the current one."""

DELAY_WEIGHT = 8
"""Additional weight of the costs of undelayed robots in the choice of a plan.

No group that is replanned has such robots, because it could delay them for others. On 8 crowded
floors, such a robot arrived 89 steps late in all, and 274 steps late without this rule.
"""

MAX_WINDOW = 10_000
"""Limit on the steps of a window, each of which takes memory for all cells."""

MAX_STATES = 2**31
"""Limit on the states of a search in a window. They have 32-bit numbers and take up to 24 bytes."""


class WindowedPlanner(PlacePlanner):
    """Planner that plans the next steps of all robots, improves the plan, and takes its first step.

    Args:
        graph: floor. With lanes as costs, robots reach more goals; see ``guidance.py``.
        window: number of steps that are planned ahead.
        groups: number of groups of robots that are replanned in each step. A result is kept if it
            is no worse. By default it is the number of robots, from ``LEAST_GROUPS`` to
            ``MOST_GROUPS`` or, with ``seconds``, as many as there is time for.
        seconds: time in each step after which no more groups are replanned.
        seed: seed of the random choices.
        turn_cost: see ``PIBT``; with it, only PIBT makes plans. Turns of robots with headings take
            steps, and have no other cost.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from agents.mapf.windows import WindowedPlanner
        >>> from warehouse_core import random_layout
        >>> graph = Graph(random_layout(12, 12, 0.2, seed=1))
        >>> run_lifelong(graph, WindowedPlanner(graph), robots=8, steps=50, seed=1).throughput
        1.1
    """

    def __init__(
        self, graph: Graph, window: int = WINDOW, groups: int | None = None, seconds: float = inf,
        seed: int = 0, turn_cost: float = 0.0,
    ) -> None:  # fmt: skip
        self.groups = None if groups is None else whole_number("groups", groups, 0)
        self.seed = seed_number(seed)
        self.seconds = real_number("seconds", seconds, finite=False)
        self.graph = graph = instance_of("graph", graph, Graph).with_turns(turn_cost)
        most = min(MAX_WINDOW, MAX_STATES // (2 * graph.places) - 1)
        self.window = whole_number("window", window, 2, most)
        prepare(roll_pibt, roll_epibt, roll_circulation, write_costs, improve, renew, reserve)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        super().reset()
        self._places = np.empty((0, 1), np.int32)

    def plan_of(self, robot: int) -> list[int]:
        """Return the cells of a robot after the step just chosen and after each later step."""
        cells: list[int] = (self._places[robot : robot + 1, 1:] % self.graph.size).ravel().tolist()
        return cells

    def _choose(self, situation: Situation, places: Integers | None) -> Integers:
        deadline = perf_counter() + self.seconds
        self._here = self._memory.places(situation.cells) if places is None else places
        self._read(situation)
        self._continue(situation)
        self._refine(deadline)
        return self._places[:, 1].astype(situation.cells.dtype)

    def _begin(self, robots: int, has_headings: bool) -> None:
        self.fields = HeadedFields(self.graph) if has_headings else Fields(self.graph)
        floor, times = self.fields.floor, self.window + 1
        self._robots = robots_of(self.graph.size, robots, self.seed)
        self._rounds, self._kind = self._make_rounds(robots, has_headings), 0
        groups = min(max(robots, LEAST_GROUPS), MOST_GROUPS) if self.seconds == inf else inf
        self._most_groups = groups if self.groups is None else self.groups
        names = "goals", "rows", "stays", "is_closed"
        shared = {name: getattr(self._robots, name) for name in names}
        self._routes = new_routes(floor, robots, times, True)._replace(**shared)
        self._frontier = new_frontier(floor, self._routes)
        self._groups = new_groups(robots, times, self.seed)
        self._since = FRESH
        ranks = np.random.default_rng(self.seed).permutation(robots) / robots
        self._memory = Memory(self.graph, ranks)
        self._places = np.asarray(self._routes.places).reshape(robots, times)
        self._places[:] = NONE

    def _make_rounds(self, robots: int, has_headings: bool) -> list[tuple[Any, Any]]:
        """Return the kernels that make a plan, each with the state of its algorithm.

        All these kernels have the same arguments.
        """
        rounds: list[tuple[Any, Any]] = [(roll_pibt, pibt_of(self.graph.size, robots))]
        if has_headings:
            rounds = [(roll_epibt, epibt_of(self.graph.neighbours[:, :WAIT], robots))]
        if self.graph.turn_cost:
            return rounds
        return [*rounds, (roll_circulation, auction_on(self.fields, robots, 1))]

    def _read(self, situation: Situation) -> None:
        """Load a situation into the buffers: robots, goals and priorities."""
        graph, cells, goals = self.fields.graph, situation.cells, situation.goals
        rows = self.fields.rows(goals)
        is_away = self.fields.matrix[rows, self._here] == FAR
        if is_away.any():  # an unreachable goal is treated as no goal
            goals = np.where(is_away, cells, goals)
            rows = self.fields.rows(goals)
        self._table = self.fields.table
        self._has_new_goal = goals != self._memory.goals
        self._order = buffer_of(self._memory.order(cells, goals, situation.urgent))
        self._is_undelayed = np.zeros(len(cells), np.intp)
        self._is_undelayed[situation.undelayed] = 1
        write(self._groups, is_in=self._is_undelayed)
        is_closed = self.graph.closed_with(situation.closed)
        write(
            self._robots, goals=goals, rows=rows * graph.places, stays=situation.stays,
            is_closed=is_closed,
        )  # fmt: skip
        passing = [cell for cell in situation.closed.tolist() if cell not in self.graph.closed]
        self._routes = self._routes._replace(closed=buffer_of(np.array(passing, np.intp)))

    def _continue(self, situation: Situation) -> None:
        """Continue the last plan, or replace it with a new one if that is better."""
        floor, routes, table = self.fields.floor, self._routes, self._table
        places, found = self._places, []
        if self._mend(situation):
            self._roll(self.window - 1, self._kind)
            if self._since < FRESH:
                self._since += 1
                write_costs(floor, routes, table)
                return
            found.append((self._cost(), self._kind, places.copy()))
        self._since = 1
        for kind in range(len(self._rounds)):
            places[:, 0] = self._here
            self._roll(0, kind)
            found.append((self._cost(), kind, places.copy()))
        _, self._kind, places[:] = min(found, key=lambda each: each[0])
        write_costs(floor, routes, table)

    def _cost(self) -> int:
        """Write the costs of the plan; return their sum, in which undelayed robots count more."""
        cost = int(write_costs(self.fields.floor, self._routes, self._table))
        return cost + DELAY_WEIGHT * int(np.array(self._routes.costs) @ self._is_undelayed)

    def _roll(self, first: int, kind: int) -> None:
        """Write the places at all times after ``first``."""
        self._robots.order[:] = self._order
        roll, state = self._rounds[kind]
        roll(self.fields.floor, self._routes, self._robots, state, self._table, first, self.window)

    def _mend(self, situation: Situation) -> bool:
        """Shift the plan by a step, and replan robots that can no longer follow it.

        Returns:
            False if no plan exists yet, or a robot has no path.
        """
        places, size = self._places, self.graph.size
        if places[0, 0] == NONE:
            return False
        places[:, :-1] = places[:, 1:]
        there, soon = places[:, 1], places[:, : CLOSED_STEPS + 1] % size
        is_closed = self.graph.closed_with(situation.closed) == 1
        enters = is_closed[soon[:, 1:]] & (soon[:, 1:] != soon[:, :-1])
        is_lost = (places[:, 0] != self._here) | enters.any(axis=1)
        is_lost |= situation.stays & (there != self._here)
        if not is_lost.any():
            return True
        places[:, 0] = self._here
        robot_in = robots_in(size, self._here % size)
        # A robot that was to enter the cell of one of these cannot continue either.
        follows = robot_in[there % size]
        while True:
            more = ~is_lost & (follows != NONE) & is_lost[follows] & (there != self._here)
            if not more.any():
                break
            is_lost |= more
        reserve_only(self.fields.floor, self._routes, np.flatnonzero(~is_lost))
        for robot in self._order:
            if is_lost[robot]:
                floor, routes = self.fields.floor, self._routes
                if find_route(floor, routes, self._frontier, self._table, robot, FAR, 0) == NONE:
                    return False
                reserve(floor, routes, robot, robot + 1)
        return True

    def _refine(self, deadline: float) -> None:
        """Replan robots with new goals, and then groups, until all are done or time is up."""
        floor, routes = self.fields.floor, self._routes
        reserve_only(floor, routes, np.arange(len(self._places)))
        replanned = buffer_of(np.flatnonzero(self._has_new_goal))
        search = floor, routes, self._frontier, self._groups, self._table
        for first in range(0, len(replanned), PORTION):
            if perf_counter() < deadline:
                renew(*search, replanned[first : first + PORTION])
        improve_until(*search, deadline, self._most_groups)
