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
    """

    local_grid: list[str]
    robot_pos: Cell
    has_item: bool
    battery: int
    steps: int
    pickup_pos: Cell | None
    dropoff_pos: Cell | None
