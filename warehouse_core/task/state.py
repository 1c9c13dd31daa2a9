"""The state of a robot and its task, and what the robot observes of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from warehouse_core.world.tiles import Cell


@dataclass(slots=True)
class WarehouseState:
    """What changes from step to step.

    It may be written between steps: a robot that is put on another open cell starts from rest in
    the middle of it.
    """

    robot_pos: Cell
    has_item: bool
    battery: int
    steps: int


class Observation(TypedDict):
    """What an agent is given; nothing in it is shared with a later observation.

    ``local_grid`` is ``2 * view_radius + 1`` equally long strings centred on the robot, ``#``
    outside the grid, the robot itself ``R`` (empty) or ``r`` (loaded). ``pickup_pos`` and
    ``dropoff_pos`` are the first ``P`` and ``D`` in row-major order, ``None`` without any.
    """

    local_grid: list[str]
    robot_pos: Cell
    has_item: bool
    battery: int
    steps: int
    pickup_pos: Cell | None
    dropoff_pos: Cell | None
