"""All verdicts of ``task/rules.py`` in tables, for many robots at once."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from warehouse_core.task.rules import CHARGE, judge, useful_actions
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import CELL_CODES, CHARGER, DROPOFF, EMPTY, PICKUP

STATION_KINDS = (EMPTY, PICKUP, DROPOFF, PICKUP + DROPOFF, CHARGER)
"""Kinds of cells that a robot can stand on; a batch uses the index.

Orders can make a cell a pickup and a dropoff. A robot uses the pickup if it holds no item, and the
dropoff if it holds one.
"""

NO_STATION = STATION_KINDS.index(EMPTY)

_BOTH = (False, True)


def _tile(kind: str, has_item: bool) -> str:
    """Return what a kind of station is to a robot."""
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
"""Bytes of a mask with padding: looking up eight bytes at once is much faster than seven."""

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


def verdict_numbers(
    actions: Integers, stations: Integers, has_item: Flags, blocked: Flags
) -> Integers:
    """Return the number of the verdict on each of ``[B]`` robots.

    ``stations`` are indices into ``STATION_KINDS``, what the robots stand on after their motion;
    ``has_item`` is from before it.
    """
    numbers: Integers = ((actions * len(STATION_KINDS) + stations) * 2 + has_item) * 2 + blocked
    return numbers


def judge_all(verdicts: Integers) -> tuple[NDArray[np.float64], Flags, Flags]:
    """Return rewards, who holds an item now and who has delivered, ``[B]`` each; see ``judge``."""
    return _REWARDS.take(verdicts), _HAS_ITEM.take(verdicts), _DELIVERED.take(verdicts)


def charging(verdicts: Integers) -> Flags:
    """Return whether ``[B]`` robots charge in a step; see ``rules.judge``."""
    return _CHARGES.take(verdicts)


def spend_and_charge(battery: Integers, capacity: int, charging: Flags) -> None:
    """Change the units that ``[B]`` robots have left, in place, by one step.

    The step costs each of them one; those that are ``charging`` gain ``CHARGE``, up to the
    capacity.
    """
    battery -= 1
    # Not the lower of full and charged, because that sum can exceed 32 bits.
    battery += charging * np.minimum(capacity - battery, CHARGE)


_STATION_NUMBERS = np.array(
    [STATION_KINDS.index(tile) if tile in STATION_KINDS else NO_STATION for tile in CELL_CODES],
    np.int16,
)


def station_numbers(tiles: NDArray[np.uint8]) -> NDArray[np.int16]:
    """Return the index into ``STATION_KINDS`` of ``[N]`` tiles given by their codes."""
    return _STATION_NUMBERS.take(tiles)


def sides_number(sides: Flags) -> NDArray[np.uint8]:
    """Return ``[...]`` numbers from 0 to 15 for ``[..., 4]`` flags of open sides."""
    return (np.packbits(sides, axis=-1)[..., 0] >> 4).astype(np.uint8)


def masks(sides: Integers, stations: Integers, has_item: Flags) -> NDArray[np.int8]:
    """Return ``[B, 7]`` int8 masks of the actions that do something; see ``useful_actions``."""
    index = (sides * len(STATION_KINDS) + stations) * 2 + has_item
    return _MASKS.take(index).view(np.int8).reshape(-1, _MASK_BYTES)[:, : len(ACTIONS)]
