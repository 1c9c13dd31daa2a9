from itertools import product

import numpy as np
import pytest

from warehouse_core.task.rules import is_truncated, judge
from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS, INVALID, action_index

N, E, S, W, WAIT, PICK, DROP = range(7)
CASES = list(product(range(INVALID + 1), ".PD", (False, True), (False, True)))


def test_the_actions_are_the_chapters_in_its_order() -> None:
    assert " ".join(ACTIONS) == "N E S W WAIT PICK DROP"
    assert DISPLACEMENTS[:4] == ((-1, 0), (0, 1), (1, 0), (0, -1))
    assert set(DISPLACEMENTS[4:]) == {(0, 0)}
    assert len(DISPLACEMENTS) == len(ACTIONS) + 1


@pytest.mark.parametrize("word", ACTIONS)
def test_a_word_is_an_action_in_any_case(word: str) -> None:
    index = ACTIONS.index(word)
    for spelling in (word, word.lower(), word.capitalize(), word.swapcase()):
        assert action_index(spelling) == index


@pytest.mark.parametrize("kind", [int, np.int8, np.int64, np.uint8, np.uint64])
def test_an_integer_of_any_kind_is_an_action(kind: type) -> None:
    assert [action_index(kind(index)) for index in range(7)] == list(range(7))
    assert action_index(np.array(3)) == 3


@pytest.mark.parametrize(
    "action", ["", "NE", "north", " N", "N\n", "0", -1, 7, 10**30, np.int8(-7)]
)
def test_an_unknown_word_or_index_is_invalid(action: str | int) -> None:
    assert action_index(action) == INVALID == 7


@pytest.mark.parametrize(
    "action", [None, 1.0, 1.5, np.float64(1), [], [1], (0,), b"N", {}, object()]
)
def test_what_is_neither_word_nor_integer_is_a_type_error(action: object) -> None:
    with pytest.raises(TypeError, match=r"allowed: one of N, E, S, W, WAIT, PICK, DROP or its"):
        action_index(action)


@pytest.mark.parametrize("move", [N, E, S, W])
def test_a_move_costs_the_step_and_a_bump_one_more(move: int) -> None:
    for tile, has_item in product(".PD", (False, True)):
        assert judge(move, tile, has_item, False) == (pytest.approx(-0.1), has_item, False)
        assert judge(move, tile, has_item, True) == (pytest.approx(-1.1), has_item, False)


def test_waiting_costs_a_little_more_than_a_move() -> None:
    assert judge(WAIT, ".", False, False) == (pytest.approx(-0.15), False, False)


def test_picking_on_a_pickup_fills_empty_hands() -> None:
    assert judge(PICK, "P", False, False) == (pytest.approx(4.9), True, False)


def test_dropping_on_a_dropoff_delivers() -> None:
    assert judge(DROP, "D", True, False) == (pytest.approx(9.9), False, True)


def test_everything_else_is_a_mistake_that_changes_nothing() -> None:
    right = {(PICK, "P", False), (DROP, "D", True)}
    for action, tile, has_item in product((PICK, DROP, INVALID), ".PD", (False, True)):
        if (action, tile, has_item) not in right:
            mistake = (pytest.approx(-0.6), has_item, False)
            assert judge(action, tile, has_item, False) == mistake


@pytest.mark.parametrize(("action", "tile", "has_item", "blocked"), CASES)
def test_cargo_changes_only_by_pick_and_drop(
    action: int, tile: str, has_item: bool, blocked: bool
) -> None:
    verdict = judge(action, tile, has_item, blocked)
    if action not in (PICK, DROP):
        assert (verdict.has_item, verdict.delivered) == (has_item, False)
    assert verdict.delivered <= has_item


@pytest.mark.parametrize(
    ("steps", "battery", "expected"),
    [(9, 1, False), (10, 1, True), (11, 1, True), (9, 0, True), (9, -1, True), (10, 0, True)],
)
def test_an_episode_is_cut_off_when_steps_or_battery_are_used_up(
    steps: int, battery: int, expected: bool
) -> None:
    assert is_truncated(steps, 10, battery) is expected


def test_a_letter_that_only_looks_like_an_action_in_upper_case_is_none() -> None:
    assert "\u017f".upper() == "S"
    assert action_index("\u017f") == INVALID
