"""Giving way: how robots that were stopped get back to their cells.

Each robot drives as if it were alone, until it touches something that is in its way; then it
brakes. A lone robot goes back at once, and so does one that only a wall stopped, if nobody drives
into its cell. Everybody else is held until all robots are at rest. Then, in one sweep:

1. Who has to go back is known at once: whoever drives to the cell that a stopped robot left, or to
   the cell that it drove to, is stopped as well, and so are those behind it. So a queue of any
   length, a jam and a ring turn back together.
2. All that are not where they belong drive there in straight lines, at the same time, with speeds
   and accelerations in proportion to their ways. The way from one robot to another then changes
   along a straight line too, from what it is to what it will be, and it is plain geometry whether
   they come closer than two radii; those that touch may part. Queues do not: a gap only grows to
   the one cell that it becomes.
3. A robot that would come too close to another waits. If only one of two can go while the other
   stands, that one goes: round a corner the follower has to leave before the one ahead comes back.
4. If nobody can go, all push: bodies without friction slide off each other, since each way leads
   to another cell. Where that does not help, each pushes alone in turn while the others brake.

When all are at rest again this is repeated, until each robot is at its target.
"""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Sequence
from itertools import product

from warehouse_core import Cell
from warehouse_physics.robot import REST, Position, Robot, apart, comes_closer
from warehouse_physics.robot_spec import RobotSpec

Ways = dict[Robot, Position]
"""Where each of some robots drives next, in metres."""


class GivingWay:
    """Moves on the robots of one action that are held; made after all have begun it."""

    def __init__(self, robots: Sequence[Robot], spec: RobotSpec) -> None:
        self._robots, self._spec, self._pushes = robots, spec, 0
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
        ways: Ways = {}
        for robot in self._robots:
            robot.look()
            if now < robot.action.deadline and not robot.has_arrived():
                ways[robot] = robot.waypoint()
            elif robot.phase != REST:
                robot.rest(now)
        if ways:
            self._drive(self._compatible(ways) or self._pushing(ways), now)
        return bool(ways)

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

    def _compatible(self, ways: Ways) -> Ways:
        """Return the ways that can be driven together, while all other robots stand."""
        going, unchecked = dict(ways), deque(ways)
        near = self._neighbours(ways)
        while unchecked:
            robot = unchecked.popleft()
            for other in near[robot] if robot in going else ():
                if not self._clash(robot, other, going):
                    continue
                alone = {robot: going[robot]}
                loser = other if other in going and not self._clash(robot, other, alone) else robot
                del going[loser]
                unchecked.extend(near[loser])
                if loser is robot:
                    break
        return going

    def _pushing(self, ways: Ways) -> Ways:
        """Return the ways of robots that push: of all, then of each alone, and so on."""
        turn, is_alone = divmod(self._pushes, 2)
        self._pushes += 1
        return dict([list(ways.items())[turn % len(ways)]]) if is_alone else ways

    def _clash(self, robot: Robot, other: Robot, going: Ways) -> bool:
        """Return whether two robots come too close when those in ``going`` drive together."""
        before = apart(robot.position, other.position)
        after = apart(going[robot], going.get(other, other.position))
        return comes_closer(before, after, 2 * self._spec.radius)

    def _neighbours(self, ways: Ways) -> dict[Robot, list[Robot]]:
        """Return for each robot those that may come near enough to touch it."""
        size, spread = self._spec.cell_size, 0.0
        for robot, way in ways.items():
            spread = max(spread, math.dist(robot.position, way))
        reach = math.ceil((2 * self._spec.radius + 2 * spread) / size)
        offsets = list(product(range(-reach, reach + 1), repeat=2))
        robots_in: dict[Cell, list[Robot]] = defaultdict(list)
        for robot in self._robots:
            robots_in[robot.cell].append(robot)
        near: dict[Robot, list[Robot]] = {}
        for robot in ways:
            row, col = robot.cell
            cells = [(row + down, col + right) for down, right in offsets]
            found = [other for cell in cells for other in robots_in.get(cell, ())]
            near[robot] = [other for other in found if other is not robot]
        return near

    def _drive(self, ways: Ways, now: int) -> None:
        lengths = {robot: math.dist(robot.position, way) for robot, way in ways.items()}
        longest = max(lengths.values())
        for robot, way in ways.items():
            robot.drive(now, way, lengths[robot] / longest)
