"""Which robots may move when several move at once; every nominal backend follows this rule.

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

If several robots have the same target, all of them stay, as rigid bodies would; the result does not
depend on the order of the robots. "Occupied" spreads backwards along a queue of robots.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from warehouse_core.motion.base import WALL_CONTACT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

Obstacle = int | str | None
"""Obstacle of a robot: another robot's number, the wall, or nothing."""


def find_stops(layout: Layout, cells: Sequence[Cell], targets: Sequence[Cell]) -> list[Obstacle]:
    """Return what stops each of ``R`` robots on its way from ``cells`` to ``targets``.

    The cells are open and different; each target is the robot's cell, or a neighbour of it.
    """
    stops: list[Obstacle] = [None if layout.is_open(target) else WALL_CONTACT for target in targets]
    stop_by_robots(stops, cells, targets)
    return stops


def stop_by_robots(
    stops: list[Obstacle], cells: Sequence[Hashable], targets: Sequence[Hashable]
) -> None:
    """Fill in the robots that stop those which no wall stops; see ``find_stops``.

    ``stops`` are obstacles of ``R`` robots, ``None`` but for walls; cells may be numbers.
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
    # Only now is it known who stays, for whatever reason; each stops the robot behind it.
    staying = [i for i, stop in enumerate(stops) if stop is not None or targets[i] == cells[i]]
    while staying:
        ahead = staying.pop()
        if ahead in followers:
            behind = followers.pop(ahead)
            stops[behind] = ahead
            staying.append(behind)


def check_joint_step(layout: Layout, cells: Sequence[Cell], targets: Sequence[Cell]) -> None:
    """Raise unless ``R`` robots can all move to their targets at once, with nothing to stop them.

    Raises:
        ValueError: naming the robots and cells: there are not ``R`` targets, a target is neither
            the robot's cell nor an open cell beside it, or two robots have the same target or
            change places.
    """
    if len(targets) != len(cells):
        raise ValueError(f"{len(targets)} cells for {len(cells)} robots; one each")
    robot_in, robot_to = {cell: robot for robot, cell in enumerate(cells)}, dict[Cell, int]()
    for robot, (cell, target) in enumerate(zip(cells, targets, strict=True)):
        if abs(cell[0] - target[0]) + abs(cell[1] - target[1]) > 1 or not layout.is_open(target):
            raise ValueError(
                f"robot {robot} is to go from {cell} to {target}, which is not an open cell beside "
                "it"
            )
        other = robot_to.setdefault(target, robot)
        if other != robot:
            raise ValueError(f"robots {other} and {robot} are both to go to {target}")
        other = robot_in.get(target, robot)
        if other < robot and targets[other] == cell:
            raise ValueError(
                f"robots {other} and {robot} are to change places, {target} and {cell}"
            )
