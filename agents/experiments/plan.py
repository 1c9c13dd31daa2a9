"""A plan: the cases of an experiment and the seeds of each, checked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from agents.errors import ParameterError
from agents.experiments.case import Case, key_of, make_case
from agents.experiments.parameters import MOST, Value, checked, find

MAX_CASES = 10_000
MAX_EPISODES = 100_000_000

DIGITS = 12
"""Of the numbers of a range."""

MAX_SEED = 2**62
"""A file of results keeps seeds as 64-bit numbers."""

Choices = Mapping[str, Sequence[Value]]
"""The values of each setting that is given; a setting that is not has its default."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What to run.

    Attributes:
        cases: no two alike.
        episodes: of each case; their seeds are ``seed``, ``seed + 1``, ...
        seed: the first.
    """

    cases: tuple[Case, ...]
    episodes: int
    seed: int

    @property
    def seeds(self) -> range:
        """The seeds of each case."""
        return range(self.seed, self.seed + self.episodes)

    @property
    def total(self) -> int:
        """The number of episodes in all."""
        return len(self.cases) * self.episodes


def make_plan(choices: Mapping[str, Any], episodes: int, seed: int) -> Plan:
    """Return the plan of every combination of choices.

    Args:
        choices: for each setting a value, a list of values, or ``{from, to, step}``.
        episodes: of each combination.
        seed: of the first episode of each.

    Raises:
        ParameterError: naming what it is, and what is allowed; also of a layout or a robot that
            cannot be used.
        AgentError: an agent that cannot be used.
        OSError: a file that cannot be read.
    """
    values = {name: spread(name, choice) for name, choice in choices.items()}
    _check_number(values, episodes)
    if not 0 <= seed <= MAX_SEED:
        raise ParameterError(f"seed is {seed}; it must be a whole number 0..{MAX_SEED}")
    try:
        combinations = [
            make_case(dict(zip(values, combination, strict=True)))
            for combination in product(*values.values())
        ]
    except ValueError as error:
        raise ParameterError(str(error)) from error
    _check_use(values, combinations)
    cases = {key_of(case): case for case in combinations}
    return Plan(tuple(cases.values()), episodes, seed)


def _check_use(values: Mapping[str, Sequence[Value]], cases: Sequence[Case]) -> None:
    """Refuse a setting that means nothing in any of the cases."""
    for name in values:
        if not any(name in case for case in cases):
            raise ParameterError(f"{name} means nothing here; it counts only {find(name).needs}")


def spread(name: str, choice: Any) -> list[Value]:
    """Return the values that a choice stands for, each checked.

    Raises:
        ParameterError: naming the setting, the value and what is allowed.
    """
    if isinstance(choice, Mapping):
        return [checked(name, value) for value in _range(name, choice)]
    values = choice if isinstance(choice, list) else [choice]
    if not values:
        raise ParameterError(f"{name} has no value; it needs at least one")
    return list(dict.fromkeys(checked(name, value) for value in values))


def _range(name: str, limits: Mapping[str, Any]) -> list[int | float]:
    """Return the numbers from a first to a last, both included."""
    find(name)
    if limits.keys() != {"from", "to", "step"}:
        raise ParameterError(f"{name} is {dict(limits)!r}; a range has the keys from, to and step")
    first, last, step = (limits[key] for key in ("from", "to", "step"))
    for key, value in limits.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{name}.{key} is {value!r}; it must be a number")
        if not abs(value) <= MOST:
            raise ParameterError(f"{name}.{key} is not within {-MOST}..{MOST}")
    if not (step > 0 and first <= last):
        raise ParameterError(f"{name} goes from {first} to {last} by {step}; it must go up")
    steps = (last - first) / step + 1e-9
    if steps >= MAX_CASES:
        raise ParameterError(
            f"{name} has {steps + 1:.0f} values; MAX_CASES = {MAX_CASES} are allowed"
        )
    # As they would be typed: 0.1 + 0.2 is 0.3, or the same value would be two.
    numbers = (first + step * number for number in range(math.floor(steps) + 1))
    return [each if isinstance(each, int) else float(f"{each:.{DIGITS}g}") for each in numbers]


def _check_number(values: Mapping[str, Sequence[Value]], episodes: int) -> None:
    count = math.prod(map(len, values.values()))
    if count > MAX_CASES:
        most = max(values, key=lambda name: len(values[name]))
        raise ParameterError(
            f"{count} combinations, {len(values[most])} of them by {most}; "
            f"MAX_CASES = {MAX_CASES} are allowed"
        )
    if count * episodes > MAX_EPISODES:
        raise ParameterError(
            f"episodes is {episodes}; with {count} combinations that makes {count * episodes}, "
            f"and MAX_EPISODES = {MAX_EPISODES} are allowed"
        )
