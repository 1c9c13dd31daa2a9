"""Who passes first after a delay: a robot that would be waited for lets others go before it.

``Dependencies`` hold the order of a plan, in which a robot that has stopped is waited for, and then
those that wait for it. Here robots are let through: a visit of a late robot is put off until after
another one of the same cell, and so are its other visits through which the two would wait for each
other, in both directions of a lane as well. Only visits to which nobody has committed are put off.
The new order has no circles but the rings of the plan, so that nobody waits forever.

Times are estimated: every robot takes as long for each cell, and may enter a cell when the robot
before it moves on. A switch often gains nothing until others follow it, so the search is simulated
annealing: at first it also accepts switches with which robots arrive later, towards its end hardly
any. It takes over the best order that it has met, which is no proved optimum.

Sources: Berndt, van Duijkeren, Palmieri and Keviczky (2020), A feedback scheme to reorder a
multi-agent execution schedule by persistently optimizing a switchable action dependency graph;
Feng, Paul, Chen and Li (2024), A real-time rescheduling algorithm for multi-robot plan execution;
Kirkpatrick, Gelatt and Vecchi (1983), Optimization by simulated annealing.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from warehouse_core import Cell
from warehouse_physics.driving.dependencies import Dependencies, Visit
from warehouse_physics.profile import Floats

MAX_TRIES = 200
"""Switches that one search tries."""

HOTTEST = 30.0
"""Temperature at the beginning of a search: seconds by which all robots together arrive later with
a switch that is accepted with a chance of 1 / e."""

SHORT = 0.5
"""Seconds of a wait for which no switch is tried."""

GAIN = 0.5
"""Seconds that a new order has to gain, for all robots together."""

WAY = 0.1
"""Weight of the time of each visit; an arrival weighs 1 more. A robot that gets farther before it
waits again counts a little, as the next switch may let it through there."""

APART = 1e5
"""Seconds between the times of robots where these are accumulated in one array."""

CLOSE = 1e-6
"""Seconds to which times are exact."""


class RouteProgress(NamedTuple):
    """How far ``R`` robots are on their ways.

    Attributes:
        passed: ``[R]``, last node whose middle each robot has passed.
        present: ``[R]``, first node whose cell it has not left, this one or the next.
        reached: ``[R]``, last node that it cannot stop before.
        starts: ``[R]`` seconds after which it would have been at its node 0, without other robots.
        pace: seconds that every robot takes for a cell.
    """

    passed: list[int]
    present: list[int]
    reached: list[int]
    starts: Floats
    pace: float


class Timetable:
    """The visits ahead of ``R`` robots, the order at each cell, and the estimated times.

    The ``N`` visits that have not begun are numbered robot by robot.
    """

    def __init__(self, ways: Dependencies, progress: RouteProgress) -> None:
        self._ways, self._progress = ways, progress
        robots, passed = range(len(progress.passed)), progress.passed
        self._lasts = [ways.last(robot) for robot in robots]
        ahead = [last - before for last, before in zip(self._lasts, passed, strict=True)]
        self._firsts = [0, *accumulate(ahead)]
        self.visits = [
            Visit(robot, number)
            for robot in robots
            for number in range(passed[robot] + 1, self._lasts[robot] + 1)
        ]
        self._ends = np.array(
            [end - 1 for end, each in zip(self._firsts[1:], ahead, strict=True) if each], int
        )
        robot_of, numbers = np.array(self.visits, int).reshape(-1, 2).T
        self._free = progress.starts[robot_of] + numbers * progress.pace
        self._shift = robot_of * APART
        visits_of: dict[Cell, list[Visit]] = {}
        self._leaders = np.full(len(self.visits), len(self.visits))
        for robot in robots:
            for number in range(progress.present[robot], self._lasts[robot] + 1):
                visit, node = Visit(robot, number), ways.node(robot, number)
                visits_of.setdefault(node.cell, []).append(visit)
                if number > passed[robot] and node.after:
                    self._lead(visit, node.after[0])
        self.orders = {cell: self._first_order(visits) for cell, visits in visits_of.items()}
        self._cells = {visit: cell for cell, order in self.orders.items() for visit in order}
        self._before: dict[tuple[int, int], Visit | None] = {}
        for order in self.orders.values():
            self._before.update(zip(order, [None, *order], strict=False))

    def times(self) -> Floats:
        """Return when robots will be in the middle of the cells of visits, ``[N]`` seconds."""
        times = np.append(self._free, -np.inf)
        while True:
            late = np.maximum(times[self._leaders] - self._free, 0.0) + self._shift
            found: Floats = self._free + np.maximum.accumulate(late) - self._shift
            if (found <= times[:-1] + CLOSE).all():
                return found
            times[:-1] = found

    def total(self, times: Floats) -> float:
        """Return how late robots are, ``times`` of their visits taken together, in seconds."""
        return float(times[self._ends].sum() + WAY * (times - self._free).sum())

    def waits(self, times: Floats) -> list[tuple[Visit, Visit]]:
        """Return the visits that wait for another robot to leave the cell, and the visits of it.

        The longest waits are first.
        """
        late = times - self._free
        waits = np.diff(late, prepend=0.0)
        starts = [at for at, end in zip(self._firsts, self._firsts[1:], strict=False) if at < end]
        waits[starts] = late[starts]
        longest = np.argsort(-waits, kind="stable")
        found = (self.visits[at] for at in longest[waits[longest] > SHORT].tolist())
        return [(visit, leader) for visit in found if (leader := self._before[visit])]

    def let_through(self, late: Visit, other: Visit) -> dict[Cell, list[Visit]]:
        """Return the orders of cells in which the robot of a visit lets another robot go first.

        Whatever has to take place before the other robot leaves the cell has to take place before
        the late one enters it. Where the late robot is in the way of that, it waits there too.

        Returns:
            The orders of the cells that change. There are none if it is not possible, because the
            late robot or another one has committed to a cell, or somebody stays in one.
        """
        (robot, least), reached = late, self._progress.reached
        before = self._progress.passed.copy()
        pending = [] if self._stays(other) else [Visit(other.robot, other.number + 1)]
        while pending:
            self._collect(pending, before, robot)
            while least > reached[robot] and self._overtaken(Visit(robot, least - 1), before):
                least -= 1
            if least <= reached[robot]:
                return {}
            for number in range(least, self._lasts[robot] + 1):
                for each in self._overtaken(Visit(robot, number), before):
                    if self._stays(each):
                        return {}
                    if each.number + 1 > before[each.robot]:
                        pending.append(Visit(each.robot, each.number + 1))
        return self._put_off(robot, least, before)

    def apply(self, orders: dict[Cell, list[Visit]]) -> dict[Cell, list[Visit]]:
        """Take over orders of cells, and return what they were before."""
        old = {cell: self.orders[cell] for cell in orders}
        self.orders |= orders
        for visits in orders.values():
            for before, visit in zip([None, *visits], visits, strict=False):
                self._before[visit] = before
                if visit.number > self._progress.passed[visit.robot]:
                    self._lead(visit, before)
        return old

    def _first_order(self, visits: Sequence[Visit]) -> list[Visit]:
        """Return visits of a cell, robot by robot, in the order in which they take place."""
        followers: dict[Visit | None, Visit] = {}
        latest: dict[int, Visit] = {}
        for visit in visits:
            after = self._ways.node(*visit).after
            followers[after[0] if after else latest.get(visit.robot)] = visit
            latest[visit.robot] = visit
        (first,) = followers.keys() - visits
        found = [followers[first]]
        while found[-1] in followers:
            found.append(followers[found[-1]])
        return found

    def _collect(self, pending: list[Visit], before: list[int], robot: int) -> None:
        """Add visits, and all that have to begin before them if ``robot`` lets them through.

        Where a visit is among them, so are those before it on the same way: ``before`` has the last
        one of each robot.
        """
        while pending:
            last = pending.pop()
            first, before[last.robot] = before[last.robot] + 1, max(before[last.robot], last.number)
            for number in range(first, last.number + 1):
                leader = self._before[last.robot, number]
                while leader and leader.robot == robot:
                    leader = self._before[leader]
                if leader and leader.robot != last.robot and leader.number >= before[leader.robot]:
                    pending.append(Visit(leader.robot, leader.number + 1))

    def _overtaken(self, visit: Visit, before: list[int]) -> list[Visit]:
        """Return the later visits of the same cell that are to begin ``before`` a visit ends."""
        order, passed = self.orders[self._cells[visit]], self._progress.passed
        return [
            each
            for each in order[order.index(visit) + 1 :]
            if passed[each.robot] < each.number <= before[each.robot]
        ]

    def _put_off(self, robot: int, least: int, before: list[int]) -> dict[Cell, list[Visit]]:
        """Return the orders in which visits of a robot, from ``least`` on, are put off."""
        found: dict[Cell, list[Visit]] = {}
        for number in range(self._lasts[robot], least - 1, -1):
            visit = Visit(robot, number)
            overtaken = self._overtaken(visit, before)
            if not overtaken:
                continue
            cell = self._cells[visit]
            order = found.setdefault(cell, [*self.orders[cell]])
            at, to = order.index(visit), order.index(overtaken[-1])
            if any(
                each.number <= self._progress.reached[each.robot] for each in order[at : to + 2]
            ):
                return {}
            order.insert(to, order.pop(at))
        return found

    def _lead(self, visit: Visit, leader: Visit | None) -> None:
        """Set the visit that has to end before another one begins, if it is of another robot."""
        at = len(self.visits)
        if leader and leader.robot != visit.robot and not self._stays(leader):
            at = self._index(Visit(leader.robot, leader.number + 1))
        self._leaders[self._index(visit)] = at

    def _index(self, visit: Visit) -> int:
        """Return the number of a visit among the ``N`` ahead, or ``N`` if it has begun."""
        ahead = visit.number - self._progress.passed[visit.robot] - 1
        return self._firsts[visit.robot] + ahead if ahead >= 0 else len(self.visits)

    def _stays(self, visit: Visit) -> bool:
        """Return whether a visit is the last of its robot."""
        return visit.number == self._lasts[visit.robot]


def find_switches(ways: Dependencies, progress: RouteProgress) -> dict[Cell, list[Visit]]:
    """Return the orders of cells in which robots arrive sooner, of the cells where these change."""
    table, stream = Timetable(ways, progress), random.Random(0)
    times, planned = table.times(), table.orders.copy()
    total = least = table.total(times)
    allowed, best, waits = least - GAIN, planned, table.waits(times)
    for tries in range(MAX_TRIES):
        if not waits:
            break
        # The square prefers long waits.
        visit, leader = waits.pop(int(len(waits) * stream.random() ** 2))
        orders = table.let_through(leader, visit)
        if not orders:
            continue
        old, temperature = table.apply(orders), HOTTEST * (1 - tries / MAX_TRIES)
        switched = table.times()
        later = table.total(switched) - total
        if later >= 0 and stream.random() >= math.exp(-later / temperature):
            table.apply(old)
            continue
        total, waits = total + later, table.waits(switched)
        if total < min(least, allowed):
            least, best = total, table.orders.copy()
    return {cell: order for cell, order in best.items() if order != planned[cell]}
