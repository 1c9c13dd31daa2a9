from itertools import product

import pytest

from warehouse_core.task.rules import charged, is_truncated, judge, useful_actions
from warehouse_core.world.actions import INVALID

N, E, S, W, WAIT, PICK, DROP = range(7)


def test_a_move_costs_the_step_and_a_bump_one_more() -> None:
    for move, tile, has_item in product((N, E, S, W), ".PDC", (False, True)):
        assert judge(move, tile, has_item, False) == (pytest.approx(-0.1), has_item, False, False)
        assert judge(move, tile, has_item, True) == (pytest.approx(-1.1), has_item, False, False)


def test_waiting_costs_a_little_more_than_a_move() -> None:
    assert judge(WAIT, ".", False, False) == (pytest.approx(-0.15), False, False, False)


def test_a_charge_adds_ten_units_up_to_a_full_battery() -> None:
    assert [charged(units, 30) for units in (0, 7, 20, 21, 29)] == [10, 17, 30, 30, 30]
    assert charged(0, 3) == 3


def test_picking_on_a_pickup_takes_the_item() -> None:
    assert judge(PICK, "P", False, False) == (pytest.approx(4.9), True, False, False)


def test_dropping_on_a_dropoff_delivers() -> None:
    assert judge(DROP, "D", True, False) == (pytest.approx(9.9), False, True, False)


def test_any_other_action_is_a_mistake_that_changes_nothing() -> None:
    right = {(PICK, "P", False), (DROP, "D", True)}
    for action, tile, has_item in product((PICK, DROP, INVALID), ".PDC", (False, True)):
        if (action, tile, has_item) not in right:
            mistake = (pytest.approx(-0.6), has_item, False, False)
            assert judge(action, tile, has_item, False) == mistake


def test_only_pick_and_drop_change_what_the_robot_holds() -> None:
    actions = set(range(INVALID + 1)) - {PICK, DROP}
    for action, tile, has_item, blocked in product(actions, ".PDC", *[(False, True)] * 2):
        assert judge(action, tile, has_item, blocked)[1:3] == (has_item, False)


def test_only_waiting_on_a_charger_charges() -> None:
    charging = [
        (action, tile)
        for action, tile, *rest in product(range(8), "#.PDC", (False, True), (False, True))
        if judge(action, tile, *rest).charges
    ]
    assert charging == [(WAIT, "C")] * 4


def test_an_action_is_useful_if_it_moves_waits_picks_or_delivers() -> None:
    sides = (True, False, False, True)
    for tile, has_item in product(".PDC", (False, True)):
        picks, drops = (tile, has_item) == ("P", False), (tile, has_item) == ("D", True)
        assert useful_actions(sides, tile, has_item) == (*sides, True, picks, drops)


@pytest.mark.parametrize(
    ("steps", "battery", "expected"), [(9, 1, False), (10, 1, True), (9, 0, True), (11, -1, True)]
)
def test_an_episode_is_truncated_when_steps_or_battery_are_used_up(
    steps: int, battery: int, expected: bool
) -> None:
    assert is_truncated(steps, 10, battery) is expected
