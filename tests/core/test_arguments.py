"""Each error names the argument, its value and what is allowed."""

import math
from typing import Any

import numpy as np
import pytest

from warehouse_core.arguments import as_cell, real_number, whole_number


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


def test_a_real_number_comes_back_as_a_float() -> None:
    for value in (0, 2, 1.5, np.float32(0.5), np.int64(1)):
        number = real_number("size", value, 0, 2)
        assert (number, type(number)) == (value, float)


def test_a_cell_is_two_integers() -> None:
    assert as_cell("start", [np.int64(1), 2]) == (1, 2)
    message = r"^start is .*; it must be two integers \(row, column\)$"
    for value in (5, (1,), (1, 2, 3), (1.5, 2), "ab", (True, 2)):
        with pytest.raises(TypeError, match=message):
            as_cell("start", value)
