"""The state of a robot and its task, and the robot's observation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from warehouse_core.world.tiles import Cell


@dataclass(slots=True)
class WarehouseState:
    """Everything about a robot that changes from step to step.

    It can be assigned between steps. A robot that is put on another open cell is then at rest in
    the middle of this cell.

    Example:
        >>> from warehouse_core import WarehouseEnv, WarehouseState
        >>> env = WarehouseEnv()
        >>> env.state = WarehouseState(robot_pos=(1, 3), has_item=False, battery=9, steps=0)
        >>> env.step("PICK")[1]
        4.9
    """

    robot_pos: Cell
    has_item: bool
    battery: int
    steps: int


class Observation(TypedDict):
    """A robot's observation; observations share no mutable object.

    ``local_grid`` is a list of ``2 * view_radius + 1`` equally long strings with the robot in the
    middle. Besides tiles it has ``#`` outside the grid, ``R`` (empty) or ``r`` (loaded) for the
    robot, ``O`` or ``o`` for another robot of a fleet, and ``H`` for a person. ``pickup_pos`` and
    ``dropoff_pos`` are the first ``P`` and ``D`` in row-major order, or ``None``.

    Example:
        >>> from warehouse_core import Observation, WarehouseEnv
        >>> observation: Observation = WarehouseEnv().reset()
        >>> observation["pickup_pos"], observation["battery"]
        ((1, 3), 200)
    """

    local_grid: list[str]
    robot_pos: Cell
    has_item: bool
    battery: int
    steps: int
    pickup_pos: Cell | None
    dropoff_pos: Cell | None
