"""Tables of all verdicts of ``task/rules.py``, for many robots at once."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.kernels import Verdicts
from warehouse_core.task.rules import CHARGE, judge, useful_actions
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import CELL_CODES, CHARGER, DROPOFF, EMPTY, PICKUP

STATION_KINDS = (EMPTY, PICKUP, DROPOFF, PICKUP + DROPOFF, CHARGER)
"""Kinds of cells on which a robot can stand. Batches use their indices.

With orders, a cell can be both a pickup and a dropoff. It counts as a pickup for a robot without an
item, and as a dropoff for a robot with one.
"""

NO_STATION = STATION_KINDS.index(EMPTY)

_BOTH = (False, True)


def _tile(kind: str, has_item: bool) -> str:
    """Return the tile as which a kind of cell counts for a robot."""
    return kind[-1] if has_item else kind[0]


_VERDICTS = [
    judge(action, _tile(kind, has_item), has_item, blocked)
    for action, kind, has_item, blocked in product(range(len(ACTIONS)), STATION_KINDS, _BOTH, _BOTH)
]
_REWARDS = np.array([verdict.reward for verdict in _VERDICTS])
_HAS_ITEM = np.array([verdict.has_item for verdict in _VERDICTS])
_DELIVERED = np.array([verdict.delivered for verdict in _VERDICTS])
_CHARGES = np.array([verdict.charges for verdict in _VERDICTS])

_MASK_BYTES = 8
"""Bytes of a mask with padding, because looking up eight bytes is much faster than seven."""

_MASKS = np.array(
    [
        [
            *useful_actions(sides, _tile(kind, has_item), has_item),
            *[False] * (_MASK_BYTES - len(ACTIONS)),
        ]
        for sides, kind, has_item in product(product(_BOTH, repeat=4), STATION_KINDS, _BOTH)
    ],
    np.int8,
).view(np.uint64)[:, 0]

VERDICTS = Verdicts(
    len(STATION_KINDS), _REWARDS, _HAS_ITEM, _DELIVERED, _CHARGES,
    _MASKS.view(np.int8).reshape(-1, _MASK_BYTES),
)  # fmt: skip
"""All verdicts and masks for the kernels of fleets."""


def verdict_numbers(
    actions: Integers, stations: Integers, has_item: Flags, blocked: Flags
) -> Integers:
    """Return the number of the verdict on each robot, ``[B]``.

    Args:
        actions: ``[B]`` indices into ``ACTIONS``.
        stations: ``[B]`` indices into ``STATION_KINDS`` of the cells after the motion.
        has_item: ``[B]`` flags of robots that held an item before the motion.
        blocked: ``[B]`` flags of robots that were blocked.
    """
    numbers: Integers = ((actions * len(STATION_KINDS) + stations) * 2 + has_item) * 2 + blocked
    return numbers


def judge_all(verdicts: Integers) -> tuple[NDArray[np.float64], Flags, Flags]:
    """Return rewards, flags of held items and flags of deliveries, ``[B]`` each; see ``judge``."""
    return _REWARDS.take(verdicts), _HAS_ITEM.take(verdicts), _DELIVERED.take(verdicts)


def charging(verdicts: Integers) -> Flags:
    """Return the flags ``[B]`` of robots that charge in a step; see ``rules.judge``."""
    return _CHARGES.take(verdicts)


def spend_and_charge(battery: Integers, capacity: int, charging: Flags) -> None:
    """Update the battery units ``[B]`` in place for one step.

    The step costs each robot one unit. Robots that are ``charging`` then gain ``CHARGE`` units, up
    to the capacity.
    """
    battery -= 1
    # The sum of battery and charge is not computed first, because it could exceed 32 bits.
    battery += charging * np.minimum(capacity - battery, CHARGE)


STATION_NUMBERS = np.array(
    [STATION_KINDS.index(tile) if tile in STATION_KINDS else NO_STATION for tile in CELL_CODES],
    np.int16,
)
"""Index into ``STATION_KINDS`` of each tile, by its code."""


def station_numbers(tiles: NDArray[np.uint8]) -> NDArray[np.int16]:
    """Return the indices ``[N]`` into ``STATION_KINDS`` of tiles, given by their codes."""
    return STATION_NUMBERS.take(tiles)


def sides_number(sides: Flags) -> NDArray[np.uint8]:
    """Return a number ``[...]`` from 0 to 15 for each four flags ``[..., 4]`` of open sides."""
    return (np.packbits(sides, axis=-1)[..., 0] >> 4).astype(np.uint8)


def masks(sides: Integers, stations: Integers, has_item: Flags) -> NDArray[np.int8]:
    """Return the masks ``[B, 7]`` int8 of actions with an effect; see ``useful_actions``."""
    index = (sides * len(STATION_KINDS) + stations) * 2 + has_item
    return _MASKS.take(index).view(np.int8).reshape(-1, _MASK_BYTES)[:, : len(ACTIONS)]
