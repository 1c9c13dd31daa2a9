"""The state of a robot and its task, and the observation of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from warehouse_core.world.tiles import Cell


@dataclass(slots=True)
class WarehouseState:
    """Everything about a robot that changes from step to step.

    It may be assigned between steps: a robot put on another open cell starts at rest in the middle
    of it.

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
    """One robot's view of the warehouse; observations share no mutable object.

    ``local_grid`` is ``2 * view_radius + 1`` equally long strings centred on the robot: ``#``
    outside the grid, ``R`` (empty) or ``r`` (loaded) for the robot, ``O`` or ``o`` for another
    robot of a fleet and ``H`` for a person. ``pickup_pos`` and ``dropoff_pos`` are the first ``P``
    and ``D`` in row-major order, or ``None``.

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
