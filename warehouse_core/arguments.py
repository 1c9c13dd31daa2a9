"""Checks of arguments; each error names the argument, its value and what is allowed.

A check returns the value as a plain Python object, such as an ``int`` for any object with
``__index__``. Callers keep the returned value instead of the given one, which may be mutable or
follow other rules of arithmetic.
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
"""The same limit for a single ``WarehouseEnv``, which counts with Python's integers."""

MAX_VIEW_RADIUS = 1000
"""Limit on the cells that a robot sees in each direction. Its view then has 4 million cells."""

MAX_ENVS = 2**20
"""Limit on the warehouses of a batch."""

MAX_SEED = 2**512 - 1
"""Limit on seeds, which is large enough for any common digest. Records can store such seeds."""

Kind = TypeVar("Kind")


def whole_number(
    name: str, value: SupportsIndex, minimum: int | None = None, maximum: int | None = None
) -> int:
    """Return an argument as an ``int``.

    Raises:
        TypeError: it is not an integer; ``True`` and ``False`` do not count as integers.
        ValueError: it is less than ``minimum`` or more than ``maximum``.
    """
    try:
        if type(value) is int:  # the common case, and the fastest
            number = value
        elif isinstance(value, (bool, np.bool_)):
            raise TypeError
        else:
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

    Negative seeds are refused because Python's ``random`` treats -7 like 7.

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
    """Return an argument as a ``float``.

    With ``above``, the number must be greater than ``minimum``. Infinity is allowed only if
    ``finite`` is false.

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
    """Return an argument as a ``bool``; it must be true or false.

    Raises:
        TypeError: it is neither.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} is {brief(value)}; it must be True or False")
    return bool(value)


def one_of(name: str, value: Any, allowed: Iterable[str | None]) -> Any:
    """Return an argument that must be one of the allowed words.

    ``None`` is accepted if it is among them.

    Raises:
        ValueError: it is something else; the message lists the allowed words.
    """
    words = [*allowed]
    if not (value is None or isinstance(value, str)) or value not in words:
        raise ValueError(f"{name} is {brief(value)}; allowed: {', '.join(map(str, words))}")
    return value


def instance_of(name: str, value: Any, kind: type[Kind]) -> Kind:
    """Return an argument that must be an instance of a class.

    Raises:
        TypeError: it is not an instance of ``kind``.
    """
    if not isinstance(value, kind):
        raise TypeError(f"{name} is {brief(value)}; it must be a {kind.__name__}")
    return value


def with_methods(name: str, value: Kind, *methods: str) -> Kind:
    """Return an argument that must be an object with these methods.

    Raises:
        TypeError: it lacks one of the methods, or is a class.
    """
    if isinstance(value, type) or not all(callable(getattr(value, each, None)) for each in methods):
        needed = listed(methods)
        raise TypeError(f"{name} is {brief(value)}; it must be an object with {needed}")
    return value


def sequence_of(name: str, value: Any, kind: type[Kind]) -> tuple[Kind, ...]:
    """Return an argument as a tuple; it must be a sequence of instances of a class.

    Raises:
        TypeError: it is not such a sequence.
    """
    is_sequence = isinstance(value, Sequence) and not isinstance(value, (str, bytes, range))
    if not is_sequence or not all(isinstance(each, kind) for each in value):
        raise TypeError(f"{name} is {brief(value)}; it must be a sequence of {kind.__name__}")
    return tuple(value)


def as_cell(name: str, value: tuple[int, int], parts: str = "(row, column)") -> tuple[int, int]:
    """Return an argument as a cell or another pair of two ``int``.

    Raises:
        TypeError: it is not a pair of integers; the message names its ``parts``.
    """
    try:
        if type(value) is not tuple and not isinstance(value, (np.ndarray, Sequence)):
            raise TypeError  # a set has no order
        first, second = value
        return whole_number(name, first), whole_number(name, second)
    except Exception:  # a user's ``__iter__`` may raise anything
        raise TypeError(f"{name} is {brief(value)}; it must be two integers {parts}") from None


def settle(record: object, **values: object) -> None:
    """Replace the fields of a frozen dataclass with checked values."""
    for name, value in values.items():
        object.__setattr__(record, name, value)
