"""How robots that block each other give way and get back to their cells.

Each robot drives as if it were alone, until it touches something that is in its way. Then it
brakes. A lone robot drives back at once. So does a robot that was stopped by a wall only, if no
other robot drives into its cell. All other robots are held until everyone is at rest. They then get
back in rounds:

1. A robot that drives to the cell which a stopped robot left, or to its goal, is stopped too, and
   so are the robots behind it. It is therefore known at once who has to go back, and a queue of any
   length, a jam and a ring turn back together.
2. All robots that are not at their targets drive there in straight lines and at the same time, with
   speeds and accelerations in proportion to their distances. The vector from one robot to another
   then changes along a straight line, from its present value to its final one. In a queue, the gap
   between two robots only grows, until it is one cell.
3. Round a corner, two robots may come too close and push each other. The one in front, which comes
   back, pushes its follower in the direction in which it drives anyway, and bodies without friction
   slide off each other.
4. Several robots may get stuck together where one alone would not. So in every second round a
   single robot drives, each in turn, while the others brake.
5. A light robot may be trapped behind a heavy one that is at its target and brakes. All robots use
   the same acceleration ``a``, so the light one of mass ``m`` pushes with ``m * a`` and the heavy
   one of mass ``M`` resists with ``M * a``. After ``STUCK`` rounds, the robot that is farthest from
   its target therefore drives alone with the full force ``F`` of its motor, up to ``TRIES`` times.
   It then pushes with at least ``F - D``, where ``D`` is the drag of a loaded robot. Since the
   motor can accelerate a loaded robot at ``a``, this is at least ``M * a``.

The rounds are repeated until each robot is at its target.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

from warehouse_core import Cell
from warehouse_physics.phases import REST
from warehouse_physics.robot import Robot

STUCK = 20
"""Rounds after which robots use their full force. Nearly all jams end in fewer rounds."""

TRIES = 8
"""Largest number of consecutive drives of one robot with its full force."""


class GivingWay:
    """The rounds in which the held robots of one action get back.

    It is created after all robots have begun the action.
    """

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
        """Start the next round at substep ``now``, when no robot has anything to do.

        Returns:
            True if any robot drives or still moves.
        """
        moving = [robot for robot in self._robots if robot.is_moving()]
        for robot in moving:  # pushed by a robot that it already touched
            robot.halt(now)
        if moving:
            return True
        self._stop_followers()
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
        """Let the robot that is farthest from its target drive alone with its full force.

        It alternates between both paths around a wall.
        """
        for robot in self._robots:
            robot.restore_braking()
        if (self._rounds - STUCK) % TRIES == 0 or self._caught not in away:
            distances = [math.dist(robot.position, robot.action.target) for robot in away]
            self._caught = away[distances.index(max(distances))]
        waypoint = self._caught.waypoint(longer_first=bool(self._rounds % 2))
        self._caught.drive(now, waypoint, is_hard=True)

    def _stop_followers(self) -> None:
        """Make all robots give up that a robot which has given up is in the way of."""
        stopped = [robot for robot in self._robots if robot.action.gave_up]
        while stopped:
            action = stopped.pop().action
            for cell in (action.home, action.goal):
                for robot in self._drivers.pop(cell, ()):
                    if not robot.action.gave_up:
                        robot.give_up()
                        stopped.append(robot)

    def _next_of(self, away: list[Robot]) -> list[Robot]:
        """Return all robots, or in every second round one of them, each in turn."""
        turn, is_alone = divmod(self._rounds, 2)
        return [away[turn % len(away)]] if is_alone and away else away

    def _drive(self, robots: Sequence[Robot], now: int) -> None:
        waypoints = [robot.waypoint() for robot in robots]
        lengths = list(map(math.dist, (robot.position for robot in robots), waypoints))
        longest = max(lengths, default=0.0)
        for robot, waypoint, length in zip(robots, waypoints, lengths, strict=True):
            robot.drive(now, waypoint, length / longest)
