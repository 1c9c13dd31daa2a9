"""Spaces of a fleet's observations and state, with functions that make both from arrays.

``R`` is the number of robots, and ``K`` is ``MAX_STATE_ORDERS``.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from warehouse_core.arguments import MAX_STEPS, one_of
from warehouse_core.fleet.env import FleetEnv
from warehouse_core.gymnasium_env.spaces import FORMS, Extent, Form, make_form
from warehouse_core.task.encoding import FLEET_TILES, ObservationArrays, vector, vector_limits
from warehouse_core.world.moves import HEADINGS

MAX_STATE_ORDERS = 32
"""Number of open orders in a state. These are the oldest; missing orders are -1."""

ORDER_FEATURES = 6
"""Count of the numbers of an order in a state: its cells, release and due time."""


def make_fleet_form(name: str, extent: Extent, fleet: FleetEnv) -> Form:
    """Return a form of a robot's observations by name.

    Raises:
        ValueError: the name is unknown, or ``make_form`` fails.
    """
    if one_of("observation", name, FORMS) == "image":
        return make_form("image", extent)
    if name == "dict":
        form = make_form("dict", extent)
        known = dict(cast(spaces.Dict, form.space))
        extra: dict[str, spaces.Space[Any]] = {
            "action_mask": spaces.Box(0, 1, (len(fleet.settings.actions),), np.int8)
        }
        if fleet.settings.orders is not None:
            extra["due"] = spaces.Box(-1, MAX_STEPS, (1,), np.int32)
        if fleet.layout.chargers and not fleet.settings.is_lone:
            extra["charger_pos"] = known["pickup_pos"]
        if fleet.settings.has_headings:
            extra["heading"] = spaces.Discrete(len(HEADINGS))
        return Form(spaces.Dict(known | extra), form.of)
    has_headings = fleet.settings.has_headings
    low, high = vector_limits(*extent, FLEET_TILES, has_headings=has_headings)
    return Form(spaces.Box(low, high, dtype=np.float32), _fleet_vector)


def _fleet_vector(arrays: ObservationArrays) -> NDArray[np.float32]:
    return vector(arrays, FLEET_TILES)  # a lambda could not be pickled


def state_space(extent: Extent, fleet: FleetEnv) -> spaces.Box[Any]:
    """Return the space of the vectors of ``state_of``."""
    cell = (extent.height, extent.width)
    heading = (len(HEADINGS) - 1,) if fleet.settings.has_headings else ()
    robot = (*cell, 1, extent.battery, *cell, *cell, MAX_STEPS, 1, *heading)
    order = (*cell, *cell, extent.max_steps, MAX_STEPS)
    high = np.array(
        [extent.max_steps, *robot * fleet.settings.robots, *order * MAX_STATE_ORDERS], np.float32
    )
    return spaces.Box(np.full(len(high), -1, np.float32), high, dtype=np.float32)


def state_of(fleet: FleetEnv) -> NDArray[np.float32]:
    """Return the state of a fleet as a vector of ``1 + 10 R + 6 K`` numbers, float32.

    ======  =======================================================================================
    1       steps taken.
    10 R    for each robot: row and column, 1 if it holds an item, battery units, row and column of
            its pickup and of its dropoff, step by which its order is due, 1 if it has not ended.
    6 K     for each of the oldest ``K`` open orders: row and column of its pickup and of its
            dropoff, steps at which it was released and is due.
    ======  =======================================================================================

    Missing values are -1. Robots with headings have 11 numbers, of which the heading is the last.

    Args:
        fleet: a fleet that has been reset.
    """
    arrays, robots = fleet.arrays(), fleet.settings.robots
    columns = (
        arrays["robot_pos"],
        np.asarray(arrays["has_item"])[:, None],
        arrays["battery"],
        arrays["pickup_pos"],
        arrays["dropoff_pos"],
        arrays.get("due", np.full((robots, 1), -1)),
        np.logical_not(fleet.ended)[:, None],
        np.reshape(fleet.headings, (robots, -1)),  # no column without headings
    )
    orders, waiting = fleet.orders, np.full((MAX_STATE_ORDERS, ORDER_FEATURES), -1)
    for row, number in enumerate(fleet.open_orders[:MAX_STATE_ORDERS]):
        order = orders[number]
        waiting[row] = (*order.pickup, *order.dropoff, order.released, order.due)
    parts = [fleet.steps], np.hstack(columns).ravel(), waiting.ravel()
    return np.concatenate(parts, dtype=np.float32, casting="unsafe")
