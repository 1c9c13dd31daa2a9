"""Observations as arrays, for spaces, networks and tables.

``encode`` converts the chapter's observation into arrays, and ``vector`` joins them into a single
vector. Both need only the observation, so agents can call them too. ``K`` is
``2 * view_radius + 1``. Functions that take arrays accept any leading shape ``...``, a single
observation or a batch.
"""

from __future__ import annotations

from typing import Any, TypedDict, cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.task.state import Observation
from warehouse_core.world.moves import HEADINGS
from warehouse_core.world.tiles import (
    CELL_CODES,
    CHARGER,
    CODE_OF_BYTE,
    DROPOFF,
    MOVE_DELTAS,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    PICKUP,
    WALL,
    Cell,
)

NOWHERE: Cell = (-1, -1)
"""Cell of a pickup or dropoff that does not exist; observations without arrays have ``None``."""

CELLS_PER_UNIT, STEPS_PER_UNIT = 10.0, 100.0
"""Units of distances and times in a vector, chosen so that typical values are about 1."""

MARKED_TILES = (WALL, PICKUP, DROPOFF)
"""Characters of a window that have entries of their own in a vector."""

FLEET_TILES = (*MARKED_TILES, CHARGER, OTHER_EMPTY, OTHER_LOADED, PERSON)
"""Such characters for a robot of a fleet, which also sees chargers, other robots and people."""

OTHER_NUMBERS = 11
"""Length of a vector without the window."""

_CELL, _STEP = 1 / CELLS_PER_UNIT, 1 / STEPS_PER_UNIT

_SCALES = np.array([_CELL, _CELL, *[1.0, _CELL, _CELL] * 2, 1.0, _STEP, _STEP], np.float32)


_DIRECTIONS = np.array([MOVE_DELTAS[heading] for heading in HEADINGS], np.float32)

Window = NDArray[np.uint8] | NDArray[np.bool_]
"""Codes of cells, or the flags that ``marks`` returns for them."""


class ObservationArrays(TypedDict):
    """An observation as arrays, with the keys of the chapter's observation.

    Attributes:
        local_grid: ``[..., K * K]`` uint8, the window row by row in ``CELL_CODES``; or
            ``[..., K * K * T]`` bool, the ``marks`` of the window.
        robot_pos: ``[..., 2]`` int32, row and column.
        has_item: ``[...]`` int64, 0 or 1; an ``int`` for a single observation.
        battery: ``[..., 1]`` int32, units left.
        steps: ``[..., 1]`` int32, steps taken.
        pickup_pos: ``[..., 2]`` int32, ``NOWHERE`` if the layout has none.
        dropoff_pos: ``[..., 2]`` int32, likewise.
    """

    local_grid: Window
    robot_pos: NDArray[np.int32]
    has_item: int | NDArray[np.int64]
    battery: NDArray[np.int32]
    steps: NDArray[np.int32]
    pickup_pos: NDArray[np.int32]
    dropoff_pos: NDArray[np.int32]


class FleetArrays(ObservationArrays, total=False):
    """The observations of ``N`` robots: ``ObservationArrays`` with three more keys.

    Attributes:
        due: ``[N, 1]`` int32, step by which the robot's order is due, or -1. Present only if the
            fleet has orders.
        charger_pos: ``[N, 2]`` int32, nearest charger. Present only if the layout has chargers, and
            not for a single robot without orders.
        heading: ``[N]`` int64, 0 to 3 for N, E, S and W. Present only if robots have headings.
    """

    due: NDArray[np.int32]
    charger_pos: NDArray[np.int32]
    heading: NDArray[np.int64]


def encode(observation: Observation) -> ObservationArrays:
    """Return an observation as new arrays that share no memory with it.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.task import encode
        >>> arrays = encode(WarehouseEnv(view_radius=1).reset())
        >>> arrays["local_grid"].shape, arrays["robot_pos"]
        ((9,), array([1, 1], dtype=int32))
    """
    return arrays_of(window_of(observation), numbers_of(observation), observation["has_item"])


def window_of(observation: Observation) -> NDArray[np.uint8]:
    """Return the window of an observation as codes ``[K * K]``."""
    text = "".join(observation["local_grid"]).encode()
    return np.frombuffer(bytearray(text.translate(CODE_OF_BYTE)), np.uint8)


def numbers_of(observation: Observation) -> NDArray[np.int32]:
    """Return all numbers of an observation as one array, which is faster than five arrays."""
    pickup, dropoff = observation["pickup_pos"] or NOWHERE, observation["dropoff_pos"] or NOWHERE
    budgets = observation["battery"], observation["steps"]
    return np.array((*observation["robot_pos"], *pickup, *dropoff, *budgets), np.int32)


def arrays_of(window: Window, numbers: NDArray[np.int32], has_item: bool) -> ObservationArrays:
    """Return the arrays of an observation, which share memory with ``window`` and ``numbers``."""
    return {
        "local_grid": window,
        "robot_pos": numbers[0:2],
        "has_item": int(has_item),
        "battery": numbers[6:7],
        "steps": numbers[7:8],
        "pickup_pos": numbers[2:4],
        "dropoff_pos": numbers[4:6],
    }


def vector(arrays: ObservationArrays, tiles: tuple[str, ...] = MARKED_TILES) -> NDArray[np.float32]:
    """Return an observation as a vector ``[..., L]`` float32, with ``L = T * K * K + 11``.

    Robots with headings have two more numbers.

    ======================  =====================================================================
    ``T * K * K``           1 or 0 for each cell of the window, row by row, and each of ``tiles``:
                            whether the cell has this tile. By default these are wall, pickup and
                            dropoff. Everything else counts as floor.
    2                       rows and columns to the next cell in the direction of the heading.
                            Only robots with headings have these numbers.
    2                       row and column of the robot, in tens of cells.
    3                       1 if there is a pickup, then the rows and columns from the robot to it,
                            in tens of cells. All are 0 without a pickup.
    3                       the same numbers for the dropoff.
    1                       1 if the robot holds an item.
    2                       battery units left and steps taken, in hundreds.
    ======================  =====================================================================

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.task import encode, vector
        >>> vector(encode(WarehouseEnv().reset())).shape
        (86,)
    """
    window = arrays["local_grid"]
    marked = window if window.dtype == np.bool_ else marks(window, tiles)
    # Writing each number for all rows at once is several times as fast as writing row by row.
    rest = np.empty((OTHER_NUMBERS, *marked.shape[-2::-1]), np.float32)
    rest[0:2] = robot = arrays["robot_pos"].T
    for first, station in ((2, arrays["pickup_pos"].T), (5, arrays["dropoff_pos"].T)):
        exists = station >= 0
        rest[first] = exists[0]
        rest[first + 1 : first + 3] = (station - robot) * exists
    rest[8] = np.asarray(arrays["has_item"]).T
    rest[9:10] = arrays["battery"].T
    rest[10:11] = arrays["steps"].T
    headings = cast(FleetArrays, arrays).get("heading")
    facing = () if headings is None else (_DIRECTIONS[headings],)
    return np.concatenate([marked, *facing, rest.T * _SCALES], axis=-1, dtype=np.float32)


def marks(window: NDArray[Any], tiles: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return ``[..., C * T]``, whether each of the cells ``[..., C]`` has each of ``T`` tiles."""
    is_tile = np.empty((*window.shape, len(tiles)), np.bool_)
    for number, tile in enumerate(tiles):
        np.equal(window, CELL_CODES[tile], out=is_tile[..., number])
    return is_tile.reshape(*window.shape[:-1], -1)


def vector_limits(
    height: int,
    width: int,
    view_radius: int,
    battery: int,
    max_steps: int,
    tiles: tuple[str, ...] = MARKED_TILES,
    *,
    has_headings: bool = False,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lower and upper bounds of a vector, each ``[L]`` float32."""
    window = len(tiles) * (2 * view_radius + 1) ** 2
    row, col = height - 1, width - 1
    low = np.array([0, 0, *[0, -row, -col] * 2, 0, 0, 0], np.float32) * _SCALES
    high = np.array([row, col, *[1, row, col] * 2, 1, battery, max_steps], np.float32) * _SCALES
    direction = np.ones(2 if has_headings else 0, np.float32)
    return (
        np.concatenate([np.zeros(window, np.float32), -direction, low]),
        np.concatenate([np.ones(window, np.float32), direction, high]),
    )
