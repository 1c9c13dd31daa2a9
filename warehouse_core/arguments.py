"""Checks of arguments; each error names the argument, its value and what is allowed.

A check returns the value in its plain form, an ``int`` for what has ``__index__``, which is to be
kept in place of what was given: that one may change, or calculate otherwise.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Sequence
from typing import Any, SupportsIndex, TypeVar

import numpy as np

from warehouse_core.wording import brief, listed

MAX_STEPS = 2**31 - 1
"""Limit on the steps of an episode, and on battery units, in int32 arrays."""

MAX_BUDGET = 2**63 - 1
"""Limit on the same of a lone ``WarehouseEnv``, which counts in Python's integers."""

MAX_VIEW_RADIUS = 1000
"""Limit on the cells that a robot sees in each direction; a window has four million then."""

MAX_ENVS = 2**20
"""Limit on the warehouses of a batch."""

MAX_SEED = 2**512 - 1
"""Limit on seeds: numbers of any common digest, which a record can hold."""

Kind = TypeVar("Kind")


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
        number = int(operator.index(value))
    except Exception:  # a user's ``__index__`` may raise anything
        raise TypeError(f"{name} is {brief(value)}; it must be an integer") from None
    if minimum is not None and number < minimum:
        raise ValueError(f"{name} is {brief(number)}; it must be at least {minimum}")
    if maximum is not None and number > maximum:
        raise ValueError(f"{name} is {brief(number)}; it must be at most {brief(maximum)}")
    return number


def seed_number(seed: SupportsIndex | None, name: str = "seed") -> int | None:
    """Return a seed as an ``int``, 0 to ``MAX_SEED``, or ``None``.

    Negative seeds are refused, as Python's ``random`` draws the same from -7 as from 7.

    Raises:
        TypeError: it is not an integer.
        ValueError: it is out of range.
    """
    return None if seed is None else whole_number(name, seed, 0, MAX_SEED)


def real_number(
    name: str,
    value: float,
    minimum: float = 0,
    maximum: float = math.inf,
    *,
    above: bool = False,
    finite: bool = True,
) -> float:
    """Return an argument as a ``float``; with ``above`` it must exceed ``minimum``.

    Infinity is allowed only without ``finite``.

    Raises:
        ValueError: it is not a number, not finite or out of range.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} is {brief(value)}; it must be a number")
    try:
        number = float(value)
    except OverflowError:  # an int that no float can hold
        number = math.inf
    is_allowed = (math.isfinite(number) or not finite) and minimum <= number <= maximum
    if not is_allowed or (above and number == minimum):
        lower = f"{'above' if above else 'at least'} {minimum:g}"
        upper = f"at most {maximum:g}" if maximum < math.inf or not finite else "finite"
        raise ValueError(f"{name} is {brief(value)}; it must be {lower} and {upper}")
    return number


def flag(name: str, value: bool) -> bool:
    """Return an argument that must be true or false as a ``bool``.

    Raises:
        TypeError: it is neither.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} is {brief(value)}; it must be True or False")
    return bool(value)


def one_of(name: str, value: Any, allowed: Iterable[str | None]) -> Any:
    """Return an argument that must be one of some words, or ``None`` if that is among them.

    Raises:
        ValueError: it is something else; the message lists what is allowed.
    """
    words = [*allowed]
    if not (value is None or isinstance(value, str)) or value not in words:
        raise ValueError(f"{name} is {brief(value)}; allowed: {', '.join(map(str, words))}")
    return value


def instance_of(name: str, value: Any, kind: type[Kind]) -> Kind:
    """Return an argument that must be of a class.

    Raises:
        TypeError: it is not.
    """
    if not isinstance(value, kind):
        raise TypeError(f"{name} is {brief(value)}; it must be a {kind.__name__}")
    return value


def with_methods(name: str, value: Kind, *methods: str) -> Kind:
    """Return an argument that may be of any class with some methods.

    Raises:
        TypeError: it lacks one of them.
    """
    if isinstance(value, type) or not all(callable(getattr(value, each, None)) for each in methods):
        needed = listed(methods)
        raise TypeError(f"{name} is {brief(value)}; it must be an object with {needed}")
    return value


def sequence_of(name: str, value: Any, kind: type[Kind]) -> tuple[Kind, ...]:
    """Return an argument that must be a sequence of instances of a class as a tuple.

    Raises:
        TypeError: it is not.
    """
    is_sequence = isinstance(value, Sequence) and not isinstance(value, (str, bytes, range))
    if not is_sequence or not all(isinstance(each, kind) for each in value):
        raise TypeError(f"{name} is {brief(value)}; it must be a sequence of {kind.__name__}")
    return tuple(value)


def as_cell(name: str, value: tuple[int, int], parts: str = "(row, column)") -> tuple[int, int]:
    """Return an argument as a cell, or another pair, of two ``int``.

    Raises:
        TypeError: it is not one; the message names its ``parts``.
    """
    try:
        if not isinstance(value, (tuple, list, np.ndarray, Sequence)):  # a set has no order
            raise TypeError
        first, second = value
        return whole_number(name, first), whole_number(name, second)
    except Exception:  # a user's ``__iter__`` may raise anything
        raise TypeError(f"{name} is {brief(value)}; it must be two integers {parts}") from None


def settle(record: object, **values: object) -> None:
    """Put checked values in the fields of a frozen dataclass, in place of those given."""
    for name, value in values.items():
        object.__setattr__(record, name, value)
