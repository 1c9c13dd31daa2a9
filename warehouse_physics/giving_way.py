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
5. A light robot may be caught behind a heavy one that is back and brakes. At the acceleration ``a``
   of all robots the one with mass ``m`` pushes with ``m * a``, and the one with ``M`` holds with
   ``M * a``. So after ``STUCK`` rounds the robot that is farthest from its target drives alone, up
   to ``TRIES`` times, with all the force ``F`` of its motor. It then pushes with ``F - D`` or more,
   where ``D`` is the drag of a loaded robot. As the motor can drive a loaded robot at ``a``, that
   is no less than ``M * a``.

When all are at rest again this is repeated, until each robot is at its target.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

from warehouse_core import Cell
from warehouse_physics.robot import REST, Robot

STUCK = 20
"""Rounds after which robots use all their force; nearly all jams end in fewer."""

TRIES = 8
"""Most drives in a row of one robot that uses all its force."""


class GivingWay:
    """Moves on the robots of one action that are held; made after all have begun it."""

    def __init__(self, robots: Sequence[Robot]) -> None:
        self._robots, self._rounds = robots, 0
        self._caught = robots[0]
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
        if away and self._rounds >= STUCK:
            self._force_through(away, now)
        else:
            self._drive(self._next_of(away), now)
        self._rounds += 1
        return bool(away)

    def _force_through(self, away: Sequence[Robot], now: int) -> None:
        """Let the robot that was farthest from its target drive alone with all its force.

        It tries both ways around a wall, in turn.
        """
        for robot in self._robots:
            robot.brake_as_usual()
        if (self._rounds - STUCK) % TRIES == 0 or self._caught not in away:
            ways = [math.dist(robot.position, robot.action.target) for robot in away]
            self._caught = away[ways.index(max(ways))]
        waypoint = self._caught.waypoint(longer_first=bool(self._rounds % 2))
        self._caught.drive(now, waypoint, is_hard=True)

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
        return [away[turn % len(away)]] if is_alone and away else away

    def _drive(self, robots: Sequence[Robot], now: int) -> None:
        waypoints = [robot.waypoint() for robot in robots]
        lengths = list(map(math.dist, (robot.position for robot in robots), waypoints))
        longest = max(lengths, default=0.0)
        for robot, waypoint, length in zip(robots, waypoints, lengths, strict=True):
            robot.drive(now, waypoint, length / longest)
