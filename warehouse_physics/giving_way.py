"""Giving way: how robots that were stopped get back to their cells.

Each robot drives as if it were alone, until it touches something that is in its way; then it
brakes. A lone robot goes back at once, and so does one that only a wall stopped, if nobody drives
into its cell. Everybody else is held until all robots are at rest. Then, in one sweep:

1. Who has to go back is known at once: whoever drives to the cell that a stopped robot left, or to
   the cell that it drove to, is stopped as well, and so are those behind it. So a queue of any
   length, a jam and a ring turn back together.
2. All that are not where they belong drive there in straight lines, at the same time, with speeds
   and accelerations in proportion to their ways. The way from one robot to another then changes
   along a straight line too, from what it is to what it will be: in a queue a gap only grows, to
   the one cell that it becomes.
3. Round a corner two may come too close, and push. The one ahead, which comes back, pushes its
   follower where that drives anyway, and bodies without friction slide off each other.
4. Where all together get stuck, one alone does not: every other time one of them drives, in turn,
   while the others brake.

When all are at rest again this is repeated, until each robot is at its target.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

from warehouse_core import Cell
from warehouse_physics.robot import REST, Robot


class GivingWay:
    """Moves on the robots of one action that are held; made after all have begun it."""

    def __init__(self, robots: Sequence[Robot]) -> None:
        self._robots, self._rounds = robots, 0
        self._drivers: dict[Cell, list[Robot]] = defaultdict(list)
        for robot in robots:
            if robot.action.goal != robot.action.home:
                self._drivers[robot.action.goal].append(robot)
        for robot in robots:
            robot.action.is_followed = robot.action.home in self._drivers

    def move_on(self, now: int) -> bool:
        """Move on when no robot has anything to do at substep ``now``; return whether one has."""
        moving = [robot for robot in self._robots if robot.is_moving()]
        for robot in moving:  # pushed by one that it had already touched
            robot.halt(now)
        if moving:
            return True
        self._tell_all()
        away = []
        for robot in self._robots:
            robot.look()
            if now < robot.action.deadline and not robot.has_arrived():
                away.append(robot)
            elif robot.phase != REST:
                robot.rest(now)
        self._drive(self._next_of(away), now)
        return bool(away)

    def _tell_all(self) -> None:
        """Make all give up that are stopped by those that have."""
        stopped = [robot for robot in self._robots if robot.action.gave_up]
        while stopped:
            action = stopped.pop().action
            for cell in (action.home, action.goal):
                for robot in self._drivers.pop(cell, ()):
                    if not robot.action.gave_up:
                        robot.give_up()
                        stopped.append(robot)

    def _next_of(self, away: list[Robot]) -> list[Robot]:
        """Return all robots, or every other time one of them in turn."""
        turn, is_alone = divmod(self._rounds, 2)
        self._rounds += 1
        return [away[turn % len(away)]] if is_alone and away else away

    def _drive(self, robots: Sequence[Robot], now: int) -> None:
        waypoints = [robot.waypoint() for robot in robots]
        lengths = list(map(math.dist, (robot.position for robot in robots), waypoints))
        longest = max(lengths, default=0.0)
        for robot, waypoint, length in zip(robots, waypoints, lengths, strict=True):
            robot.drive(now, waypoint, length / longest)
