import numpy as np
import pytest

from warehouse_core.world.actions import ACTIONS, DISPLACEMENTS, INVALID, action_index, valid_action


def test_the_actions_are_the_chapters_in_its_order() -> None:
    assert " ".join(ACTIONS) == "N E S W WAIT PICK DROP"
    assert DISPLACEMENTS[:4] == ((-1, 0), (0, 1), (1, 0), (0, -1))
    assert set(DISPLACEMENTS[4:]) == {(0, 0)}
    assert len(DISPLACEMENTS) == len(ACTIONS) + 1


def test_a_word_is_an_action_in_any_case() -> None:
    for index, word in enumerate(ACTIONS):
        for spelling in (word, word.lower(), word.capitalize(), word.swapcase()):
            assert action_index(spelling) == index


@pytest.mark.parametrize("kind", [int, np.int8, np.uint64, np.array])
def test_an_integer_of_any_kind_is_an_action(kind: type) -> None:
    assert [action_index(kind(index)) for index in range(7)] == list(range(7))
    assert [valid_action(kind(index)) for index in range(7)] == list(range(7))


@pytest.mark.parametrize("action", ["", "NE", " N", "0", -1, 7, 10**30, np.int8(-7)])
def test_an_unknown_word_or_index_is_invalid(action: str | int) -> None:
    assert action_index(action) == INVALID == 7


def test_a_letter_that_is_an_action_only_in_upper_case_is_invalid() -> None:
    assert "\u017f".upper() == "S"
    assert action_index("\u017f") == INVALID


@pytest.mark.parametrize("action", [None, 1.0, np.float64(1), [1], b"N"])
def test_an_action_of_another_type_raises(action: object) -> None:
    with pytest.raises(TypeError, match=r"allowed: one of N, E, S, W, WAIT, PICK, DROP or its"):
        action_index(action)
    with pytest.raises(TypeError, match=r"allowed: an integer 0\.\.6"):
        valid_action(action)


@pytest.mark.parametrize("action", [-1, 7])
def test_a_valid_action_is_in_range(action: int) -> None:
    with pytest.raises(ValueError, match=f"action {action} is out of range"):
        valid_action(action)
