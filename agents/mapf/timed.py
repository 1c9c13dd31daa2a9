"""Windowed plans in seconds: a step is the time of a cell at top speed, and corners take longer.

A robot that turns a corner, or turns back, is then late for its plan, and so is whoever has to wait
for it at a cell. Where nobody knows that, robots come to crossings at other times than planned, and
brake there for those who are later. So the planner counts corners as part of a way, and keeps a
clock for each robot: one that is late by half a step stays for a step, and the plan of the others
goes on from there.

Bodies of a fleet that drive through need no clocks, as they show by the room in their ways how late
they are; see ``Ways``. In short steps of a motion they get room at different times, and do not move
in joint steps: a plan is made once in the time of a cell, and until the next one each robot goes on
as soon as it has room, in the order of the plan at each cell. The next plan goes on from there.

How much time corners take is measured: a robot drives round one, without and with an item.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil, inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from agents.mapf.graph import Graph
from agents.mapf.passing import PassingOrder
from agents.mapf.planner import Situation
from agents.mapf.windows import GROUPS, WINDOW, WindowedPlanner
from warehouse_core.motion.base import DrivesThrough, Motion, cell_steps_of
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

if TYPE_CHECKING:  # loading pymunk takes long, and fleets on the grid do without it
    from warehouse_physics import RobotSpec

__all__ = ["Clocks", "Pace", "TimedPlanner", "pace_of"]

LATE = 0.5
"""Steps by which a robot is late when it stays for a step."""

HELD = 3
"""Times of a cell without room after which a robot is held where it is."""


class Pace(NamedTuple):
    """Steps that a robot takes beyond one for each cell of its way.

    Attributes:
        corner: steps at each corner that it turns.
        half_turn: steps where it turns back.

    Example:
        >>> from agents.mapf.timed import Pace
        >>> Pace(corner=0.4).half_turn
        0.0
    """

    corner: float = 0.0
    half_turn: float = 0.0


@lru_cache(maxsize=16)
def pace_of(spec: RobotSpec) -> Pace:
    """Return the pace of a robot, as its body drives: the mean of those without and with an item.

    Example:
        >>> from agents.mapf.timed import pace_of
        >>> from warehouse_physics import RobotSpec
        >>> pace = pace_of(RobotSpec())
        >>> 0 < pace.corner < 1 < pace.half_turn
        True
    """
    loads = [spec, replace(spec, mass=spec.total_mass(loaded=True), payload_mass=0.0)]
    return Pace(*np.mean([_driven(each) for each in loads], axis=0).tolist())


def _driven(spec: RobotSpec) -> tuple[float, float]:
    """Return how many steps later a robot is behind a corner, and where it has turned back."""
    from agents.mapf.execution import drive_through

    braking = spec.top_speed**2 / (2 * spec.attainable_acceleration(loaded=False))
    length = 1 + ceil(braking / spec.cell_size)  # where it drives at top speed
    width = 2 * length + 1
    floor = Layout(["." * width] * (length + 1))
    out = list(range(length + 1))
    ways = (
        range(width),
        [*out, *(length + width * row for row in out[1:])],
        [*out, *reversed(out[:-1])],
    )
    times = [drive_through(floor, np.array(way)[:, None], spec).seconds for way in ways]
    straight, *others = (seconds * spec.top_speed / spec.cell_size for seconds in times)
    corner, half_turn = (max(steps - straight, 0.0) for steps in others)
    return corner, half_turn


class Clocks:
    """How late ``R`` robots are that keep the order of a plan at each cell.

    Attributes:
        late: ``[R]`` steps.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.timed import Clocks, Pace
        >>> from warehouse_core import Layout
        >>> clocks = Clocks(Graph(Layout(["..", ".."])), 1, Pace(corner=0.25))
        >>> for before, after in ((0, 1), (1, 3), (3, 2)):
        ...     clocks.add(np.array([before]), np.array([after]))
        >>> clocks.late
        array([0.5])
    """

    def __init__(self, graph: Graph, robots: int, pace: Pace) -> None:
        self._graph, self._now, self.late = graph, 0.0, np.zeros(robots)
        corner, half_turn = pace
        self._turns = np.array([0.0, corner, half_turn, corner])
        self._headings = np.full(robots, -1)
        self._left = np.full(graph.size, -inf)  # time at which the last robot was out of a cell

    def add(self, before: Integers, after: Integers) -> None:
        """Add a joint step from cells to cells, ``[R]``."""
        self._now += 1
        late, moves = self.late, np.flatnonzero(before != after)
        late[before == after] -= 1  # who stays makes up for it
        np.maximum(late, 0.0, out=late)
        out, into, first = before[moves], after[moves], self._headings[moves]
        headings = (self._graph.neighbours[out, :4] == into[:, None]).argmax(axis=1)
        late[moves] += np.where(first < 0, 0.0, self._turns[(headings - first) % 4])
        self._headings[moves] = headings
        while True:  # a cell is entered once the last robot is out of it, perhaps in this step
            self._left[out] = self._now + late[moves]
            waits = np.maximum(late[moves], self._left[into] - self._now)
            if (waits == late[moves]).all():
                break
            late[moves] = waits


class Follower:
    """Lets robots that drive through pass cells in the order of plans in steps of a cell.

    Args:
        windows: planner of the joint steps.
        cell_steps: steps of the motion in which a robot crosses a cell, about.
    """

    def __init__(self, windows: WindowedPlanner, cell_steps: int) -> None:
        self._windows, self._cell_steps = windows, cell_steps
        self._cells: Integers = np.empty(0, np.intp)
        self._goals = self._since = self._cells
        self._order: PassingOrder | None = None
        self._steps = 0

    def next_cells(self, situation: Situation) -> Integers:
        """Return the end of the way of each robot after the next step of the motion."""
        cells, goals = situation.cells, situation.goals
        if len(cells) != len(self._cells):
            self._since, self._order = np.zeros(len(cells), np.intp), None
        else:
            self._since = np.where(cells == self._cells, self._since + 1, 1)
        if self._order and self._order.cells() != cells.tolist():
            self._order = None  # robots were led by somebody else
        self._steps += 1
        is_due = self._steps >= self._cell_steps or not np.array_equal(goals, self._goals)
        self._cells, self._goals = cells.copy(), goals.copy()
        if self._order is None or is_due:
            self._order, self._steps = self._planned(situation), 0
        able = np.flatnonzero(~situation.stays).tolist()
        is_closed = set(situation.closed.tolist())
        ways = self._order.ways
        able = [each for each in able if is_closed.isdisjoint(ways[each][1:2])]
        self._order.move(self._order.movers(able))
        return np.array(self._order.cells(), cells.dtype)

    def plan_of(self, robot: int) -> list[int]:
        """Return the cells of a robot from the end of the step just chosen on; see ``Planner``."""
        return self._order.ways[robot] if self._order and robot < len(self._order.ways) else []

    def _planned(self, situation: Situation) -> PassingOrder:
        """Return the order of a plan that goes on from the present one."""
        since, usual = self._since, self._cell_steps
        # Whoever should have room by now will have it soon, and moves in this step of the plan.
        is_late = (since >= usual) & (since <= HELD * usual) & (situation.cells != situation.goals)
        stays = situation.stays & ~is_late
        if self._order:
            late = np.flatnonzero(stays).tolist()
            self._windows.go_on(self._order.plan(self._windows.window - 1, late))
        self._windows.next_cells(situation._replace(stays=stays))
        return PassingOrder(self._windows.planned_cells)


class TimedPlanner:
    """Plans as ``WindowedPlanner`` does, with the seconds that corners take.

    Without a motion it plans for the default robot.

    Args:
        graph: floor.
        window: see ``WindowedPlanner``, as for the next arguments.
        groups: groups of robots.
        seconds: time in each step.
        seed: seed of the order in groups.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from agents.mapf.timed import TimedPlanner
        >>> from warehouse_core import shelf_layout
        >>> graph = Graph(shelf_layout(aisle=2))
        >>> run = run_lifelong(graph, TimedPlanner(graph), robots=4, steps=20, seed=1)
    """

    def __init__(
        self,
        graph: Graph,
        window: int = WINDOW,
        groups: int = GROUPS,
        seconds: float = inf,
        seed: int = 0,
    ) -> None:
        self._given = window, groups, seconds, seed
        self._floor = graph
        self._windows = WindowedPlanner(graph, *self._given)  # until the pace is known
        self._pace: Pace | None = None
        self._has_clocks = True
        self._cell_steps = 1
        self.reset()

    @property
    def graph(self) -> Graph:
        """Graph of the present plans; see ``GraphPlanner``."""
        return self._windows.graph

    def plan_for(self, motion: Motion) -> None:
        """Plan for the robots of a fleet; see ``MotionPlanner``."""
        drives = isinstance(motion, DrivesThrough)
        self._cell_steps = round(cell_steps_of(motion)) if drives else 1
        spec: RobotSpec | None = getattr(motion, "spec", None) if drives else None
        self._set_pace(pace_of(spec) if spec else Pace(), has_clocks=False)

    def reset(self) -> None:
        """Forget the last episode."""
        self._windows.reset()
        self._clocks: Clocks | None = None
        is_short = self._cell_steps > 1
        self._follower = Follower(self._windows, self._cell_steps) if is_short else None

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step; see ``Planner``."""
        if self._pace is None:
            from warehouse_physics import RobotSpec

            self._set_pace(pace_of(RobotSpec()), has_clocks=True)
        assert self._pace is not None
        if self._follower:
            return self._follower.next_cells(situation)
        if not self._has_clocks:
            return self._windows.next_cells(situation)
        if self._clocks is None or len(self._clocks.late) != len(situation.cells):
            self._clocks = Clocks(self.graph, len(situation.cells), self._pace)
        stays = situation.stays | (self._clocks.late > LATE)
        chosen = self._windows.next_cells(situation._replace(stays=stays))
        self._clocks.add(situation.cells, chosen)
        return chosen

    def plan_of(self, robot: int) -> list[int]:
        """Return the cells of a robot from the end of the step just chosen on; see ``Planner``."""
        return (self._follower or self._windows).plan_of(robot)

    def _set_pace(self, pace: Pace, has_clocks: bool) -> None:
        self._pace, self._has_clocks = pace, has_clocks
        self._windows = WindowedPlanner(self._floor, *self._given, turn_cost=pace.corner)
        self.reset()
