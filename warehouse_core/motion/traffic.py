"""Who may move when several robots move at once: the rule that every nominal backend keeps.

Robots start together, each towards its own or a neighbouring cell. Read the table from the top;
the first line that fits a robot decides.

| case          | the robot wants a cell that             | it ends | stopped by             |
| ------------- | --------------------------------------- | ------- | ---------------------- |
| waiting       | it is in already                        | there   | nothing                |
| wall          | is a wall or off the grid               | stays   | the wall               |
| same target   | another moving robot wants too          | stays   | the first such robot   |
| head-on       | another robot leaves for this robot's   | stays   | that robot             |
| occupied      | a robot is in that stays, for any cause | stays   | that robot             |
| following     | a robot is in that moves away           | moves   | nothing                |
| cycle         | belongs to a ring of three or more that | moves   | nothing                |
|               | all move on                             |         |                        |

Where several want one cell all of them stay: that is what bodies do, and it needs no order among
the robots. "Occupied" spreads backwards along a queue until nobody is stopped anew.
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
        layout: where the walls are.
        cells: ``R`` different open cells.
        targets: for each robot its own cell or a neighbour of it.
    """
    stops: list[Stop] = [None if layout.is_open(target) else WALL_CONTACT for target in targets]
    robot_in = {cell: robot for robot, cell in enumerate(cells)}
    movers = [i for i, stop in enumerate(stops) if stop is None and targets[i] != cells[i]]
    for i in movers:
        stops[i] = _rival(i, movers, cells, targets, robot_in)
    _spread(stops, movers, cells, targets, robot_in)
    return stops


def _rival(
    robot: int,
    movers: Sequence[int],
    cells: Sequence[Cell],
    targets: Sequence[Cell],
    robot_in: dict[Cell, int],
) -> int | None:
    """Return the robot that wants the same cell, or else the one that comes head-on."""
    for other in movers:
        if other != robot and targets[other] == targets[robot]:
            return other
    other = robot_in.get(targets[robot], robot)
    return other if other != robot and targets[other] == cells[robot] else None


def _spread(
    stops: list[Stop],
    movers: Sequence[int],
    cells: Sequence[Cell],
    targets: Sequence[Cell],
    robot_in: dict[Cell, int],
) -> None:
    """Stop whoever wants the cell of a robot that stays, until nobody is stopped anew."""
    changed = True
    while changed:
        changed = False
        for robot in movers:
            ahead = robot_in.get(targets[robot])
            if stops[robot] is not None or ahead is None:
                continue
            if stops[ahead] is not None or targets[ahead] == cells[ahead]:
                stops[robot] = ahead
                changed = True
