"""An observation as arrays: what a space, a network or a table can hold.

``encode`` turns the chapter's observation into arrays; ``vector`` lays them end to end. Both know
nothing that the observation does not say, so that an agent can call them too. ``K`` is
``2 * view_radius + 1``; functions that take arrays take them with any leading shape ``...``, which
is how one observation and a batch of them are the same thing here.
"""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from warehouse_core.layout import DROPOFF, PICKUP, WALL, Cell
from warehouse_core.sight import CELL_CODES, CODE_OF_BYTE
from warehouse_core.warehouse_env import Observation, WarehouseEnv

NOWHERE: Cell = (-1, -1)
"""Stands for a pickup or dropoff that the layout does not have, which is ``None`` elsewhere."""

CELLS_PER_UNIT, STEPS_PER_UNIT = 10.0, 100.0
"""What a vector counts distances and times in, so that on usual layouts they are about 1."""

PLANES = (WALL, PICKUP, DROPOFF)
"""The tiles that each have a plane of the window in a vector."""


class Arrays(TypedDict):
    """An observation as arrays, with the keys of the chapter's.

    Attributes:
        local_grid: ``[..., K * K]`` uint8, the window row by row in ``sight.CELL_CODES``.
        robot_pos: ``[..., 2]`` int32, row and column.
        has_item: ``[...]`` int64, 0 or 1; a plain ``int`` where there is no batch.
        battery: ``[..., 1]`` int32, units left.
        steps: ``[..., 1]`` int32, steps taken.
        pickup_pos: ``[..., 2]`` int32, ``NOWHERE`` where the layout has none.
        dropoff_pos: ``[..., 2]`` int32, likewise.
    """

    local_grid: NDArray[np.uint8]
    robot_pos: NDArray[np.int32]
    has_item: int | NDArray[np.int64]
    battery: NDArray[np.int32]
    steps: NDArray[np.int32]
    pickup_pos: NDArray[np.int32]
    dropoff_pos: NDArray[np.int32]


def encode(observation: Observation) -> Arrays:
    """Return an observation as fresh arrays that share nothing with it or with each other."""
    window = bytearray("".join(observation["local_grid"]).encode().translate(CODE_OF_BYTE))
    array, whole = np.array, np.int32
    return {
        "local_grid": np.frombuffer(window, np.uint8),
        "robot_pos": array(observation["robot_pos"], whole),
        "has_item": int(observation["has_item"]),
        "battery": array((observation["battery"],), whole),
        "steps": array((observation["steps"],), whole),
        "pickup_pos": array(observation["pickup_pos"] or NOWHERE, whole),
        "dropoff_pos": array(observation["dropoff_pos"] or NOWHERE, whole),
    }


class Encoder:
    """Encodes what a robot senses in one episode, remembering what there is at each cell.

    What comes out is what ``encode`` gives, in less time.

    Args:
        warehouse: in which the robot is; ``forget`` must be called where its layout changes.
    """

    def __init__(self, warehouse: WarehouseEnv) -> None:
        self._warehouse = warehouse
        self._known: dict[tuple[Cell, bool], tuple[NDArray[np.uint8], NDArray[np.int32]]] = {}

    def forget(self) -> None:
        """Remember nothing any more."""
        self._known = {}

    def encode(self) -> Arrays:
        """Return what the robot senses now as fresh arrays."""
        state = self._warehouse.state
        key = (state.robot_pos, state.has_item)
        window, numbers = self._known.get(key) or self._look(key)
        # One copy for all the numbers: making each array by itself would take twice as long.
        numbers = numbers.copy()
        numbers[6], numbers[7] = state.battery, state.steps
        return {
            "local_grid": window.copy(),
            "robot_pos": numbers[0:2],
            "has_item": int(key[1]),
            "battery": numbers[6:7],
            "steps": numbers[7:8],
            "pickup_pos": numbers[2:4],
            "dropoff_pos": numbers[4:6],
        }

    def _look(self, key: tuple[Cell, bool]) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
        arrays = encode(self._warehouse.observe())
        places = (arrays["robot_pos"], arrays["pickup_pos"], arrays["dropoff_pos"])
        numbers = np.concatenate([*places, arrays["battery"], arrays["steps"]])
        self._known[key] = arrays["local_grid"], numbers
        return self._known[key]


def vector(arrays: Arrays) -> NDArray[np.float32]:
    """Return an observation as one vector of ``3 * K * K + 11`` numbers, ``[..., L]`` float32.

    ======================  =====================================================================
    ``3 * K * K``           the window row by row, once for each of ``PLANES``: 1 where that is
    2                       row and column of the robot, in tens of cells
    3                       pickup: whether there is one, then rows and columns from the robot to
                            it, in tens of cells, 0 without one
    3                       dropoff, likewise
    1                       whether the robot holds an item
    2                       battery units left and steps taken, in hundreds
    ======================  =====================================================================
    """
    window, robot = arrays["local_grid"], arrays["robot_pos"]
    planes = [window == CELL_CODES[tile] for tile in PLANES]
    ways = [_way(robot, arrays["pickup_pos"]), _way(robot, arrays["dropoff_pos"])]
    has_item = np.asarray(arrays["has_item"])[..., None]
    times = [arrays["battery"] / STEPS_PER_UNIT, arrays["steps"] / STEPS_PER_UNIT]
    parts = [*planes, robot / CELLS_PER_UNIT, *ways, has_item, *times]
    return np.concatenate(parts, axis=-1, dtype=np.float32, casting="unsafe")


def _way(robot: NDArray[Any], station: NDArray[Any]) -> NDArray[Any]:
    """Return whether there is a station, and the way to it."""
    exists = station[..., :1] >= 0
    return np.concatenate([exists, (station - robot) * exists / CELLS_PER_UNIT], axis=-1)


def vector_limits(
    height: int, width: int, view_radius: int, battery: int, max_steps: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lowest and the highest vector that there can be, each ``[L]`` float32."""
    window = len(PLANES) * (2 * view_radius + 1) ** 2
    cells = np.array([height - 1, width - 1]) / CELLS_PER_UNIT
    times = np.array([battery, max_steps]) / STEPS_PER_UNIT
    way = [1.0, *cells]
    high = np.concatenate([np.ones(window), cells, way, way, [1.0], times])
    low = np.concatenate([np.zeros(window + 2), *[[0.0, *-cells]] * 2, np.zeros(3)])
    return low.astype(np.float32), high.astype(np.float32)
