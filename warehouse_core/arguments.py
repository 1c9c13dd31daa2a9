"""Checks of arguments; each error names the argument, its value and what is allowed."""

from __future__ import annotations

import math
import operator
from typing import SupportsIndex

import numpy as np

MAX_STEPS = 2**31 - 1
"""Limit on the steps of an episode, and on battery units, in int32 arrays."""


def whole_number(
    name: str, value: SupportsIndex, minimum: int | None = None, maximum: int | None = None
) -> int:
    """Return an argument as an ``int``.

    Raises:
        TypeError: it is not an integer; ``True`` and ``False`` are none either.
        ValueError: it is less than ``minimum`` or more than ``maximum``.
    """
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}; it must be an integer") from None
    if minimum is not None and number < minimum:
        raise ValueError(f"{name} is {number}; it must be at least {minimum}")
    if maximum is not None and number > maximum:
        raise ValueError(f"{name} is {number}; it must be at most {maximum}")
    return number


def real_number(
    name: str, value: float, minimum: float = 0, maximum: float = math.inf, *, above: bool = False
) -> float:
    """Return a finite argument as a ``float``; with ``above`` it must exceed ``minimum``.

    Raises:
        ValueError: it is not a number, not finite or out of range.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} is {value!r}; it must be a number")
    try:
        number = float(value)
    except OverflowError:  # an int that no float can hold
        number = math.inf
    is_allowed = math.isfinite(number) and minimum <= number <= maximum
    if not is_allowed or (above and number == minimum):
        lower = f"{'above' if above else 'at least'} {minimum:g}"
        upper = "finite" if maximum == math.inf else f"at most {maximum:g}"
        raise ValueError(f"{name} is {value!r}; it must be {lower} and {upper}")
    return number


def as_cell(name: str, value: tuple[int, int], parts: str = "(row, column)") -> tuple[int, int]:
    """Return an argument as a cell, or another pair, of two ``int``.

    Raises:
        TypeError: it is not one; the message names its ``parts``.
    """
    try:
        first, second = value
        return whole_number(name, first), whole_number(name, second)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {value!r}; it must be two integers {parts}") from None
