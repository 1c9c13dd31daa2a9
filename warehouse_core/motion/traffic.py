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

from collections.abc import Sequence

from warehouse_core.motion.base import WALL_CONTACT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

Stop = int | str | None
"""What stops a robot: another robot's number, the wall, or nothing."""


def find_stops(layout: Layout, cells: Sequence[Cell], targets: Sequence[Cell]) -> list[Stop]:
    """Return what stops each of ``R`` robots on its way from ``cells`` to ``targets``.

    Args:
        layout: the layout with the walls.
        cells: ``R`` different open cells.
        targets: for each robot its own cell or a neighbour of it.
    """
    stops: list[Stop] = [None if layout.is_open(target) else WALL_CONTACT for target in targets]
    robot_in = {cell: robot for robot, cell in enumerate(cells)}
    movers_to: dict[Cell, list[int]] = {}
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
    staying = [i for i, stop in enumerate(stops) if stop is not None or targets[i] == cells[i]]
    while staying:
        ahead = staying.pop()
        if ahead in followers:
            behind = followers.pop(ahead)
            stops[behind] = ahead
            staying.append(behind)
    return stops
