"""The observation of one robot of a fleet, as a dictionary."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.task.encoding import FleetArrays
from warehouse_core.task.state import Observation
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tiles import CELL_CODES, Cell


class FleetObservation(Observation, total=False):
    """The observation of a fleet's robot: the chapter's keys and up to three more.

    ``pickup_pos`` and ``dropoff_pos`` are the pickup and the dropoff of the robot's order. In
    ``local_grid``, ``O`` and ``o`` are other robots without and with an item, and ``H`` is a
    person. ``C`` is a charger, and ``P`` is a cell where an order waits for this robot or for any.

    Attributes:
        due: step by which the robot's order is due, or ``None``. Present only if the fleet has
            orders.
        charger_pos: nearest charger, or ``None``. Present only if the layout has chargers, and not
            for a single robot without orders.
        heading: ``"N"``, ``"E"``, ``"S"`` or ``"W"``. Present only if robots have headings.

    Example:
        >>> from warehouse_core import FleetEnv
        >>> from warehouse_core.fleet import FleetObservation
        >>> env = FleetEnv(robots=2, orders=0.1, seed=1)
        >>> arrays, info = env.reset()
        >>> observation: FleetObservation = env.observe(robot=0)
        >>> observation["robot_pos"], observation["due"]
        ((1, 1), None)
    """

    due: int | None
    charger_pos: Cell | None
    heading: str


_CHARACTERS = bytes(map(ord, CELL_CODES)).ljust(256, b"?")


def observation_of(arrays: FleetArrays, row: int) -> FleetObservation:
    """Return a row of the arrays as a new dictionary."""
    window = arrays["local_grid"][row].tobytes().translate(_CHARACTERS).decode("ascii")
    side = round(len(window) ** 0.5)
    observation: FleetObservation = {
        "local_grid": [window[first : first + side] for first in range(0, len(window), side)],
        "robot_pos": _cell(arrays["robot_pos"][row]) or (-1, -1),
        "has_item": bool(np.asarray(arrays["has_item"])[row]),
        "battery": int(arrays["battery"][row, 0]),
        "steps": int(arrays["steps"][row, 0]),
        "pickup_pos": _cell(arrays["pickup_pos"][row]),
        "dropoff_pos": _cell(arrays["dropoff_pos"][row]),
    }
    if "due" in arrays:
        due = int(arrays["due"][row, 0])
        observation["due"] = None if due < 0 else due
    if "charger_pos" in arrays:
        observation["charger_pos"] = _cell(arrays["charger_pos"][row])
    if "heading" in arrays:
        observation["heading"] = HEADINGS[arrays["heading"][row]]
    return observation


def _cell(place: NDArray[Any]) -> Cell | None:
    """Return a cell given as row and column, or ``None`` for ``NOWHERE``."""
    row, col = place.tolist()
    return None if row < 0 else (row, col)
