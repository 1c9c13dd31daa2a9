"""Prioritised planning: the robots are planned one after the other, each around those before it.

Sources: Silver (2005), Cooperative pathfinding, AIIDE: cooperative A* and its windowed form. Li et
al. (2021), Lifelong multi-agent path finding in large-scale warehouses, AAAI: the rolling horizon.
Li et al. (2021), Anytime multi-agent path finding via large neighborhood search, IJCAI: groups
that are planned anew.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from math import factorial, inf
from time import perf_counter

import numpy as np

from agents.errors import PlanError
from agents.mapf.graph import EAST, Graph
from agents.mapf.planner import Situation
from agents.mapf.problem import Plan, Problem
from agents.mapf.reservations import Reservations
from agents.mapf.space_time import Moves, Way, find_way, moves_of
from warehouse_core.arguments import instance_of, real_number, seed_number, whole_number
from warehouse_core.wording import counted
from warehouse_core.world.tables import Integers

WINDOW, REPLAN = 30, 5
"""Default steps that are planned ahead, and steps until all robots are planned again."""

NO_GOAL = -1

PAUSE = 1
"""Steps for which a robot is expected to wait in its goal before it has another."""

TOLL = 10.0
"""Cost of a conflict on the way of a robot that finds no way without conflicts."""

MAX_WINDOW = 10_000
"""Limit on the steps of a window, each of which takes memory for all robots."""

MAX_PUSHES = 3
"""Robots planned again for such robots in a step, per robot of the fleet."""

GROUP = 8
"""Most robots that are planned anew together."""

REST = 20
"""Groups after which a robot can be the first of a group again."""


def solve_prioritised(problem: Problem, seconds: float) -> Plan:
    """Return a plan by cooperative A*; see ``problem.Solver``.

    The robots with the longest ways are first. If one finds no way it becomes the first of all,
    and an order that was tried before is shuffled, until the time is up.
    """
    deadline, stream = perf_counter() + seconds, random.Random(0)
    moves, starts, goals = moves_of(problem.graph), problem.starts, problem.goals
    fields = [problem.graph.distances(goal).tolist() for goal in goals]
    order = sorted(range(problem.robots), key=lambda robot: -fields[robot][starts[robot]])
    tried, failed = set[tuple[int, ...]](), None
    while len(tried) < factorial(problem.robots):
        if tuple(order) in tried:
            stream.shuffle(order)
            continue
        tried.add(tuple(order))
        taken = Reservations(problem.graph.size)
        try:
            for robot in order:
                start, goal = starts[robot], goals[robot]
                end = taken.free_from(goal)
                way = find_way(moves, fields[robot], start, goal, taken, end=end, deadline=deadline)
                if way is None:
                    failed = robot
                    break
                taken.add(robot, way.cells, stays=True)
            else:
                return Plan.of([taken.ways[robot][1] for robot in range(problem.robots)])
        except TimeoutError:
            why = "" if failed is None else f"; robot {failed} had no way in the last that failed"
            orders = counted(len(tried), "order")
            raise PlanError(f"no plan in {seconds:g} s and {orders} of priorities{why}") from None
        order.remove(robot)
        order.insert(0, robot)
    raise PlanError(f"no order of priorities has a plan; robot {failed} had no way in the last")


class WindowedPlanner:
    """Plans the next ``window`` steps of all robots, and all of them again after ``replan`` steps.

    In between robots keep their ways; only those are planned that have a new goal or that cannot
    go on as planned. Those that have had their goal longest are first. A robot that finds no way
    takes the one with the fewest conflicts, and the others of these conflicts are planned again. A
    robot without a way waits, and so does who would enter the cell of one that waits. A goal that
    no way leads to is as none.

    Args:
        graph: floor; with lanes as costs more robots reach their goals, see ``lanes.py``.
        window: steps that are planned ahead.
        replan: steps until all robots are planned again, less than ``window``.
        groups: number of groups of robots that are then planned anew, and kept if better.
        seconds: time limit for each step, after which robots without a way wait.
        seed: seed of the order in groups.
        turn_cost: see ``PIBT``.

    Attributes:
        cut_off: steps since ``reset`` in which the time limit was reached.
    """

    def __init__(
        self,
        graph: Graph,
        window: int = WINDOW,
        replan: int = REPLAN,
        groups: int = 0,
        seconds: float = inf,
        seed: int = 0,
        turn_cost: float = 0.0,
    ) -> None:
        self.window = whole_number("window", window, 2, MAX_WINDOW)
        self.replan = whole_number("replan", replan, 1, self.window - 1)
        self.groups, self.seed = whole_number("groups", groups, 0), seed_number(seed)
        self.seconds = real_number("seconds", seconds, finite=False)
        self.graph = graph = instance_of("graph", graph, Graph).with_turns(turn_cost)
        self._moves: Moves = moves_of(graph)
        self.reset()

    def reset(self) -> None:
        """Forget the last episode."""
        self.cut_off = 0
        self._now, self._stream = 0, random.Random(self.seed)
        self._goals: list[int] = []
        self._aims: list[int] = []
        self._fields: list[list[float]] = []
        self._since: list[int] = []
        self._delays: dict[int, float] = {}
        self._taken = Reservations(self.graph.size)
        self._before: Integers = np.empty(0, np.intp)
        self._headings = self._before

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step; see ``Planner``."""
        self._deadline = perf_counter() + self.seconds
        self._read(situation)
        is_due = self._now % self.replan == 0
        if is_due:
            self._taken = Reservations(self.graph.size)
        self._close(situation.closed.tolist())
        for robot in [robot for robot in self._taken.ways if not self._can_go_on(robot)]:
            self._taken.remove(robot)
        try:
            self._plan(robot for robot in range(len(self._cells)) if robot not in self._taken.ways)
            if is_due:
                self._improve()
        except TimeoutError:
            self.cut_off += 1
        self._now += 1
        return np.array(self._step(set(situation.closed.tolist())), situation.cells.dtype)

    def plan_of(self, robot: int) -> list[int]:
        """Return the cells of a robot from the end of the step just chosen on; see ``Planner``."""
        begin, way = self._taken.ways.get(robot, (self._now, []))
        return way[self._now - begin :]

    def _read(self, situation: Situation) -> None:
        """Take over what is new in a situation."""
        self._cells, self._stays = situation.cells.tolist(), situation.stays.tolist()
        goals = situation.goals.tolist()
        if len(self._goals) != len(goals):
            self._goals, self._fields = [NO_GOAL] * len(goals), [[]] * len(goals)
            self._since, self._aims = [self._now] * len(goals), goals.copy()
            self._before, self._headings = situation.cells, np.full(len(goals), EAST)
        self._places = self._cells
        if self.graph.turn_cost:
            cells = situation.cells.copy()
            self._headings = self.graph.headings(self._before, cells, self._headings)
            self._before, self._places = cells, (self._headings * self.graph.size + cells).tolist()
        for robot, goal in enumerate(goals):
            if goal != self._goals[robot]:
                self._taken.remove(robot)
                self._goals[robot], self._since[robot] = goal, self._now
                cell, field = self._cells[robot], self.graph.distances(goal)
                aim = goal if np.isfinite(field[cell]) else cell
                self._aims[robot], self._fields[robot] = aim, self.graph.distances(aim).tolist()

    def _close(self, closed: list[int]) -> None:
        """Close cells until the next replanning, and cells of robots that stay for one step."""
        taken, here = self._taken, set(self._cells)
        taken.closed.clear()
        soon = range(self._now + 1, self._now + 1 + self.replan)
        taken.close([cell for cell in closed if cell not in here], soon)
        stays = [cell for cell, stays in zip(self._cells, self._stays, strict=True) if stays]
        taken.close(stays, [self._now + 1])

    def _can_go_on(self, robot: int) -> bool:
        """Return whether the way of a robot holds for the next step."""
        begin, way = self._taken.ways[robot]
        rest, cell = way[self._now - begin :], self._cells[robot]
        if len(rest) < 2 or rest[0] != cell or (self._stays[robot] and rest[1] != cell):
            return False
        closed, size = self._taken.closed, self.graph.size
        return not closed or not any(
            to != cell and time * size + to in closed for time, to in enumerate(rest, self._now)
        )

    def _plan(self, robots: Iterable[int]) -> None:
        """Plan the ways of robots, and of the robots that they push away."""
        queue = sorted(robots, key=self._rank, reverse=True)
        pushes = MAX_PUSHES * len(self._cells)
        while queue:
            robot = queue.pop()
            way = self._find(robot)
            if way is None and pushes > 0:
                through = self._find(robot, TOLL)
                rivals = self._taken.rivals(robot, through.cells, self._now) if through else set()
                for rival in rivals:
                    self._taken.remove(rival)
                queue += sorted(rivals, key=self._rank, reverse=True)
                pushes -= len(rivals)
                way = self._find(robot)
            if way is not None:
                self._add(robot, *way)

    def _rank(self, robot: int) -> tuple[bool, int, float]:
        """Return what puts robots in the order of their priorities: those to go nowhere last."""
        is_there = self._cells[robot] == self._aims[robot]
        return is_there, self._since[robot], self._fields[robot][self._places[robot]]

    def _find(self, robot: int, toll: float = inf, taken: Reservations | None = None) -> Way | None:
        """Return a way from now on, or ``None`` if not even the next step has one."""
        taken, late = taken or self._taken, int(self._stays[robot])
        cell, goal = self._cells[robot], self._aims[robot]
        begin, window, is_there = self._now + late, self.window - late, cell == goal
        end = taken.free_from(goal, begin) if is_there else begin
        found = find_way(
            self._moves, self._fields[robot], self._places[robot], goal, taken, begin, window,
            end=end, toll=toll, deadline=self._deadline,
        )  # fmt: skip
        if found is None:
            return None
        cells = [cell] * late + found.cells
        longest = min(len(cells) + (self.window if is_there else PAUSE), self.window + 1)
        while len(cells) < longest and taken.is_free(
            (self._now + len(cells)) * self.graph.size + cells[-1]
        ):
            cells.append(cells[-1])
        return Way(cells, found.cost + late) if len(cells) > 1 else None

    def _add(self, robot: int, cells: list[int], cost: float) -> None:
        self._taken.add(robot, cells, self._now)
        self._delays[robot] = cost - self._fields[robot][self._places[robot]]

    def _improve(self) -> None:
        """Plan groups of robots anew, those around the most delayed first."""
        resting = dict.fromkeys(self._taken.ways, 0)
        for number in range(self.groups):
            late = [r for r, end in resting.items() if end <= number and self._delays[r] > 0]
            if not late:
                return
            first = max(late, key=lambda robot: self._delays[robot] + 2 * self._stream.random())
            resting[first] = number + REST
            self._plan_anew(self._group(first))

    def _group(self, first: int) -> list[int]:
        """Return a robot and those in its way, and those in theirs."""
        group, empty = [first], Reservations(self.graph.size)
        for robot in group:
            way = self._find(robot, taken=empty)
            if way is not None and len(group) < GROUP:
                rivals = self._taken.rivals(robot, way.cells, self._now)
                group += sorted(rivals.difference(group))
        return group[:GROUP]

    def _plan_anew(self, group: list[int]) -> None:
        """Plan robots in a random order, and keep it if the sum of their delays is less."""
        old = [(robot, self._taken.ways[robot][1], self._delays[robot]) for robot in group]
        left = sum(delay for _, _, delay in old)
        self._stream.shuffle(group)
        for robot in group:
            self._taken.remove(robot)
        try:
            for robot in group:
                way = self._find(robot)
                if way is None:
                    break
                self._add(robot, *way)
                left -= self._delays[robot]
                if left <= 0:
                    break
            else:
                old = []
        finally:
            for robot, _, _ in old:
                self._taken.remove(robot)
            for robot, cells, delay in old:
                self._taken.add(robot, cells, self._now)
                self._delays[robot] = delay

    def _step(self, closed: set[int]) -> list[int]:
        """Return the next cells: those planned, unless another robot waits there."""
        cells = self._cells
        chosen, movers = list(cells), dict[int, int]()
        for robot, (begin, way) in self._taken.ways.items():
            to = way[self._now - begin]
            if to != cells[robot] and to not in closed:
                chosen[robot] = to
                movers[to] = robot
        for robot, cell in enumerate(chosen):
            while cell == cells[robot] and cell in movers:
                robot = movers.pop(cell)
                chosen[robot] = cell = cells[robot]
        return chosen
