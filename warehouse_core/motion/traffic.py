"""Rules of right of way for robots that move at once; every nominal backend follows them.

Robots start together, each towards its own or a neighbouring cell. The first line of the table that
applies to a robot decides.

| case          | the robot's target cell                | it ends | stopped by             |
| ------------- | -------------------------------------- | ------- | ---------------------- |
| waiting       | is its own                             | there   | nothing                |
| wall          | is a wall or off the grid              | stays   | the wall               |
| same target   | is the target of another moving robot  | stays   | the first such robot   |
| head-on       | is left by a robot whose target is     | stays   | that robot             |
|               | this robot's cell                      |         |                        |
| occupied      | has a robot that stays, for any reason | stays   | that robot             |
| following     | has a robot that moves away            | moves   | nothing                |
| cycle         | is in a ring of three or more robots   | moves   | nothing                |
|               | that all move on                       |         |                        |

If several robots have the same target, all of them stay, as rigid bodies would. So the result does
not depend on the order of the robots. "Occupied" spreads backwards along a queue of robots.

``find_stops`` applies the table to the robots of one floor, using lists. ``ArrayTraffic`` applies
it to all robots of many floors, using NumPy arrays. ``stop_all`` does the same in a compiled loop.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.compiled import Vector, kernel
from warehouse_core.motion.base import NOTHING, WALL, WALL_CONTACT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import Cell

Numbers = NDArray[np.intp]

MAX_SMALL_FLEET = 32
"""Most robots for which lists are faster; each call of NumPy takes about a microsecond."""

MAX_SMALL_FRONT = 100
"""Most queues for which following one after the other is faster than following all at once."""

Obstacle = int | str | None
"""Obstacle of a robot: the number of another robot, the wall, or nothing."""


def find_stops(layout: Layout, cells: Sequence[Cell], targets: Sequence[Cell]) -> list[Obstacle]:
    """Return the obstacle that stops each of ``R`` robots when it moves to its target.

    Args:
        layout: layout with the walls.
        cells: open cell of each robot, all different.
        targets: next cell of each robot, which is its own cell or a neighbour of it.
    """
    stops: list[Obstacle] = [None if layout.is_open(target) else WALL_CONTACT for target in targets]
    stop_by_robots(stops, cells, targets)
    return stops


def stop_by_robots(
    stops: list[Obstacle], cells: Sequence[Hashable], targets: Sequence[Hashable]
) -> None:
    """Fill in the robots that stop other robots; see ``find_stops``.

    Args:
        stops: obstacles of ``R`` robots, in which only walls are filled in. It is changed.
        cells: cell of each robot, in any form, such as a number.
        targets: next cell of each robot.
    """
    robot_in = {cell: robot for robot, cell in enumerate(cells)}
    movers_to: dict[Hashable, list[int]] = {}
    for robot, target in enumerate(targets):
        if stops[robot] is None and target != cells[robot]:
            movers_to.setdefault(target, []).append(robot)
    followers: dict[int, int] = {}
    for target, (first, *others) in movers_to.items():
        ahead = robot_in.get(target)
        if others:
            stops[first] = others[0]
            for robot in others:
                stops[robot] = first
        elif ahead is not None and targets[ahead] == cells[first]:
            stops[first] = ahead
        elif ahead is not None:
            followers[ahead] = first
    # Now all robots that stay for another reason are known. Each stops the robot behind it.
    staying = [i for i, stop in enumerate(stops) if stop is not None or targets[i] == cells[i]]
    while staying:
        ahead = staying.pop()
        if ahead in followers:
            behind = followers.pop(ahead)
            stops[behind] = ahead
            staying.append(behind)


def check_joint_step(layout: Layout, cells: Sequence[Cell], targets: Sequence[Cell]) -> None:
    """Raise an error unless ``R`` robots can move to their targets at once without a conflict.

    Raises:
        ValueError: there are not ``R`` targets, a target is neither the robot's cell nor an open
            neighbour of it, or two robots have the same target or swap places. The message names
            the robots and cells.
    """
    if len(targets) != len(cells):
        raise ValueError(f"{len(targets)} cells for {len(cells)} robots; each robot needs one")
    robot_in, robot_to = {cell: robot for robot, cell in enumerate(cells)}, dict[Cell, int]()
    for robot, (cell, target) in enumerate(zip(cells, targets, strict=True)):
        if abs(cell[0] - target[0]) + abs(cell[1] - target[1]) > 1 or not layout.is_open(target):
            raise ValueError(
                f"robot {robot} cannot move from {cell} to {target}, which is not an open cell "
                "next to it"
            )
        other = robot_to.setdefault(target, robot)
        if other != robot:
            raise ValueError(f"robots {other} and {robot} cannot both move to {target}")
        other = robot_in.get(target, robot)
        if other < robot and targets[other] == cell:
            raise ValueError(
                f"robots {other} and {robot} cannot swap the cells {target} and {cell}"
            )


class Moves(NamedTuple):
    """Arrays of ``stop_all`` for ``N`` robots, with cells as in ``ArrayTraffic``.

    Attributes:
        cells: ``[N]`` cell of each robot.
        targets: ``[N]`` next cell of each robot, see ``ArrayTraffic.find_stops``.
        behind: ``[N]`` robot that follows each robot, or ``NOTHING``.
        robot_of: robot in each cell; old entries remain.
        rival_to: first robot that moves to each cell; ``NOTHING`` between two calls.
    """

    cells: Vector[np.intp]
    targets: Vector[np.intp]
    behind: Vector[np.intp]
    robot_of: Vector[np.intp]
    rival_to: Vector[np.intp]


@kernel
def stop_all(moves: Moves, stops: Vector[np.intp]) -> None:
    """Fill in the robots that stop other robots, numbered across all floors.

    Args:
        moves: cells and targets of the robots.
        stops: ``[N]`` ``WALL`` for robots that a wall stops, and ``NOTHING`` for all others.
    """
    cells, targets, behind = moves.cells, moves.targets, moves.behind
    robot_of, rival_to = moves.robot_of, moves.rival_to
    for robot in range(len(cells)):
        robot_of[cells[robot]] = robot
    for robot in range(len(cells)):
        target = targets[robot]
        if target != cells[robot]:
            first = rival_to[target]
            if first == NOTHING:
                rival_to[target] = robot
            else:
                stops[robot] = first
                if stops[first] == NOTHING:
                    stops[first] = robot
    for robot in range(len(cells)):
        target = targets[robot]
        rival_to[target] = NOTHING
        if target != cells[robot] and stops[robot] == NOTHING:
            ahead = robot_of[target]
            if cells[ahead] == target and targets[ahead] == cells[robot]:
                stops[robot] = ahead
            elif cells[ahead] == target:
                behind[ahead] = robot
    # Now all robots that stay for another reason are known. Each stops the robots behind it.
    for robot in range(len(cells)):
        ahead = robot
        if targets[robot] == cells[robot] or stops[robot] != NOTHING:
            while behind[ahead] != NOTHING:
                follower = behind[ahead]
                stops[follower], behind[ahead] = ahead, NOTHING
                ahead = follower
    for robot in range(len(cells)):
        behind[robot] = NOTHING


class ArrayTraffic:
    """The table for ``N`` robots on ``B`` floors, equal to ``find_stops`` on each floor.

    The floors are joined end to end, so that a cell has one number across all of them. An array
    gives the robot in each cell. It is never cleared: an old entry names a robot that is in another
    cell now.

    Args:
        cells: number of cells of all floors together.
        floors: number of floors ``B``.
        robots: number of robots on each floor.
    """

    def __init__(self, cells: int, floors: int, robots: int) -> None:
        self._robots = np.arange(floors * robots, dtype=np.intp)
        # WALL and NOTHING are negative indices, which count from the end.
        self._on_floor = np.array([*list(range(robots)) * floors, WALL, NOTHING], np.intp)
        self._robot_of = np.zeros(cells, np.intp)

    def moves(self) -> Moves:
        """Return new arrays for ``stop_all``."""
        robots = len(self._robots)
        cells, targets, behind = np.full((3, robots), NOTHING, np.intp)
        rival_to = np.full_like(self._robot_of, NOTHING)
        return Moves(cells, targets, behind, self._robot_of, rival_to)

    def find_stops(self, cells: Integers, targets: Integers, walled: Flags) -> Numbers:
        """Return the obstacles ``[N]``: ``NOTHING``, ``WALL``, or a robot's number on its floor.

        Args:
            cells: ``[N]`` cell of each robot.
            targets: ``[N]`` next cell of each robot, its own cell or a neighbour. It is the own
                cell of robots that a wall stops.
            walled: ``[N]`` flags of robots that a wall stops.
        """
        if len(cells) <= MAX_SMALL_FLEET:
            return self._on_floor.take(_listed_stops(cells, targets, walled))
        stops = np.full(len(cells), NOTHING, np.intp)
        stops[walled] = WALL
        is_waiting = targets == cells
        movers = np.flatnonzero(~is_waiting)
        goals = targets.take(movers)
        self._robot_of[cells] = self._robots
        ahead = self._robot_of.take(goals)
        self._stop_rivals(stops, movers, goals)
        is_behind = (cells.take(ahead) == goals) & (stops.take(movers) == NOTHING)
        movers, ahead = _chosen(is_behind, movers, ahead)
        is_head_on = targets.take(ahead) == cells.take(movers)
        robots, others = _chosen(is_head_on, movers, ahead)
        stops[robots] = others
        robots, others = _chosen(~is_head_on, movers, ahead)
        _stop_queues(stops, is_waiting | (stops != NOTHING), robots, others)
        return self._on_floor.take(stops)

    def _stop_rivals(self, stops: Numbers, movers: Numbers, goals: Integers) -> None:
        """Stop robots with the same target: the second stops the first, which stops all others."""
        self._robot_of[goals] = len(stops)
        np.minimum.at(self._robot_of, goals, movers)
        first = self._robot_of.take(goals)
        late, first = _chosen(first != movers, movers, first)
        stops[late] = first
        stops[first] = len(stops)
        np.minimum.at(stops, first, late)


def _listed_stops(cells: Integers, targets: Integers, walled: Flags) -> list[int]:
    """Return the obstacles of a few robots, numbered across all floors; see ``ArrayTraffic``."""
    stops: list[Obstacle] = [WALL if is_walled else None for is_walled in walled.tolist()]
    stop_by_robots(stops, cells.tolist(), targets.tolist())
    return [stop if isinstance(stop, int) else NOTHING for stop in stops]


def _stop_queues(stops: Numbers, is_still: Flags, followers: Numbers, ahead: Numbers) -> None:
    """Stop the followers of robots that stay, then their followers, and so on.

    Args:
        stops: obstacles of all robots, which are changed.
        is_still: flags of robots that stay.
        followers: robots that would move into the cell of the robot ahead, all different.
        ahead: robot ahead of each of ``followers``, all different.
    """
    behind = np.full(len(stops), NOTHING, np.intp)
    behind[ahead] = followers
    front, ahead = _chosen(is_still.take(ahead), followers, ahead)
    while len(front) > MAX_SMALL_FRONT:
        stops[front] = ahead
        following = behind.take(front)
        front, ahead = _chosen(following != NOTHING, following, front)
    stop_of, behind_of = stops.data, behind.data
    for robot, other in zip(front.tolist(), ahead.tolist(), strict=True):
        while robot != NOTHING:
            stop_of[robot] = other
            robot, other = behind_of[robot], robot


def _chosen(flags: Flags, ones: Numbers, others: Numbers) -> tuple[Numbers, Numbers]:
    """Return the flagged elements of two arrays, faster than by indexing both with flags."""
    places = flags.nonzero()[0]
    return ones.take(places), others.take(places)
