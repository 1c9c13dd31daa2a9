"""Each error names the argument, its value and what is allowed."""

import math
from typing import Any

import numpy as np
import pytest

from warehouse_core.arguments import (
    MAX_SEED,
    as_cell,
    flag,
    instance_of,
    one_of,
    real_number,
    seed_number,
    sequence_of,
    whole_number,
    with_methods,
)


def test_a_whole_number_is_an_integer_of_any_kind_within_its_limits() -> None:
    for value in (1, 3, np.int8(2), np.array(2)):
        number = whole_number("count", value, 1, 3)
        assert (number, type(number)) == (value, int)
    assert whole_number("count", -(10**30)) == -(10**30)
    with pytest.raises(ValueError, match=r"^count is 0; it must be at least 1$"):
        whole_number("count", 0, minimum=1)
    with pytest.raises(ValueError, match=r"^count is 4; it must be at most 3$"):
        whole_number("count", 4, maximum=3)
    for value in (1.0, "1", None, [1], True, np.bool_(True)):
        with pytest.raises(TypeError, match=r"^count is .*; it must be an integer$"):
            whole_number("count", value)


@pytest.mark.parametrize("value", [True, "1", None, (1.0,), 1j, np.bool_(True)], ids=repr)
def test_a_real_number_is_a_number(value: Any) -> None:
    with pytest.raises(ValueError, match=r"^size is .*; it must be a number$"):
        real_number("size", value)


@pytest.mark.parametrize(
    "value",
    [math.nan, math.inf, -math.inf, -5e-324, 2.5, 10**400],
    ids=lambda value: str(value)[:9],
)
def test_a_real_number_is_within_its_limits(value: float) -> None:
    with pytest.raises(ValueError, match=r"^size is .*; it must be at least 0 and at most 2$"):
        real_number("size", value, 0, 2)


def test_a_real_number_without_a_maximum_is_finite() -> None:
    assert real_number("size", 1e308) == 1e308
    for value in (0, -0.0, math.inf, 10**400):
        with pytest.raises(ValueError, match=r"^size is .*; it must be above 0 and finite$"):
            real_number("size", value, above=True)


def test_a_seed_is_not_negative() -> None:
    assert [seed_number(seed) for seed in (None, 0, MAX_SEED)] == [None, 0, MAX_SEED]
    for seed in (-7, MAX_SEED + 1):
        with pytest.raises(ValueError, match=r"^seed is .*; it must be at "):
            seed_number(seed)


def test_a_flag_is_true_or_false() -> None:
    assert flag("open", np.bool_(True)) is True
    for value in (0, None, "yes"):
        with pytest.raises(TypeError, match=r"^open is .*; it must be True or False$"):
            flag("open", value)


def test_a_word_is_one_of_those_that_are_listed() -> None:
    assert one_of("mode", "a", "ab") == "a"
    assert one_of("mode", None, [None, "a"]) is None
    for value in ("c", 1, None, ["a"], np.array(["a", "b"])):
        with pytest.raises(ValueError, match=r"^mode is .*; allowed: a, b$"):
            one_of("mode", value, "ab")


def test_an_object_is_of_a_class_or_has_methods() -> None:
    assert instance_of("count", 1, int) == 1
    with pytest.raises(TypeError, match=r"^count is 'x'; it must be a int$"):
        instance_of("count", "x", int)
    assert with_methods("file", "x", "upper", "lower") == "x"
    for value in (1, str):
        with pytest.raises(TypeError, match=r"^file is .*; it must be an object with upper and lo"):
            with_methods("file", value, "upper", "lower")


def test_a_sequence_has_items_of_one_class() -> None:
    assert sequence_of("parts", [1, 2], int) == (1, 2)
    for value in ([1, "x"], {1}, "ab", range(2)):
        with pytest.raises(TypeError, match=r"^parts is .*; it must be a sequence of int$"):
            sequence_of("parts", value, int)


def test_a_cell_is_two_integers() -> None:
    assert as_cell("start", [np.int64(1), 2]) == (1, 2)
    message = r"^start is .*; it must be two integers \(row, column\)$"
    for value in (5, (1,), (1, 2, 3), (1.5, 2), "ab", (True, 2), {1, 2}):
        with pytest.raises(TypeError, match=message):
            as_cell("start", value)
