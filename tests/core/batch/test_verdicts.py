from itertools import product

import numpy as np

from warehouse_core.batch.verdicts import (
    STATION_KINDS,
    charging,
    judge_all,
    masks,
    spend_and_charge,
    verdict_numbers,
)
from warehouse_core.task.rules import judge, useful_actions

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)
EMPTY, PICKUP, DROPOFF, BOTH, CHARGER = range(5)
NO, YES = False, True


def tile(station: int, has_item: bool) -> str:
    """Return what a station is to a robot."""
    return (
        "D" if station == BOTH and has_item else "P" if station == BOTH else STATION_KINDS[station]
    )


def test_verdicts_equal_those_of_the_rules() -> None:
    cases = list(product(range(7), range(5), (NO, YES), (NO, YES)))
    actions, stations, has_item, blocked = (np.array(column) for column in zip(*cases, strict=True))
    verdicts = verdict_numbers(actions, stations, has_item, blocked)
    rewards, holds, delivered = judge_all(verdicts)
    charges = charging(verdicts)
    assert (rewards.dtype, holds.dtype, delivered.dtype) == (float, bool, bool)
    for row, (action, station, has, stopped) in enumerate(cases):
        expected = judge(action, tile(station, has), has, stopped)
        assert (rewards[row], holds[row], delivered[row], charges[row]) == expected


def test_batteries_change_like_a_single_one() -> None:
    cases = list(product(range(7), range(5), (-4, 0, 1, 6, 11, 12)))
    actions, stations, units = (np.array(column) for column in zip(*cases, strict=True))
    battery = units.astype(np.int32)
    spend_and_charge(battery, 12, (actions == WAIT) & (stations == CHARGER))
    for found, (action, station, before) in zip(battery.tolist(), cases, strict=True):
        charges = (action, station) == (WAIT, CHARGER)
        assert found == (min(12, before + 9) if charges else before - 1)


def test_masks_are_the_useful_actions() -> None:
    cases = list(product(range(16), range(5), (NO, YES)))
    sides, stations, has_item = (np.array(column) for column in zip(*cases, strict=True))
    found = masks(sides.astype(np.uint8), stations, has_item)
    assert (found.shape, found.dtype) == ((160, 7), np.int8)
    for row, (number, station, has) in enumerate(cases):
        open_sides = tuple(bool(number & bit) for bit in (8, 4, 2, 1))
        expected = useful_actions(open_sides, tile(station, has), has)
        assert found[row].tolist() == list(expected)
