"""The plan of an experiment: its cases and their seeds, checked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from agents.errors import ParameterError
from agents.lab.experiments.case import Case, key_of, make_case
from agents.lab.parameters import MAX_SEED, MAX_VALUE, Value, Whole, checked, find

__all__ = ["SweepPlan", "make_plan"]

MAX_CASES = 10_000
MAX_EPISODES = 100_000_000

DIGITS = 12
"""Significant digits of the numbers in a range."""


@dataclass(frozen=True, slots=True)
class SweepPlan:
    """The episodes to run: ``episodes`` of each case, with seeds ``seed``, ``seed + 1``, ...

    Example:
        >>> from agents.lab.experiments.plan import make_plan
        >>> plan = make_plan({"memory": [5, 10]}, episodes=3, seed=7)
        >>> plan.seeds, plan.total
        (range(7, 10), 6)
    """

    cases: tuple[Case, ...]
    episodes: int
    seed: int

    @property
    def seeds(self) -> range:
        """The seeds, which all cases share."""
        return range(self.seed, self.seed + self.episodes)

    @property
    def total(self) -> int:
        """The number of episodes of all cases together."""
        return len(self.cases) * self.episodes


def make_plan(choices: Mapping[str, Any], episodes: int, seed: int) -> SweepPlan:
    """Return the plan with every combination of the choices.

    Args:
        choices: value, list of values or range ``{from, to, step}`` for each parameter.
        episodes: number of episodes of each combination.
        seed: seed of the first episode of each combination.

    Raises:
        ParameterError: a value cannot be used, or the plan is too large.

    Example:
        >>> from agents.lab.experiments.plan import make_plan
        >>> plan = make_plan({"memory": [5, 10], "escape": [True, False]}, episodes=3, seed=7)
        >>> len(plan.cases), plan.total
        (3, 9)
    """
    values = {name: spread(name, choice) for name, choice in choices.items()}
    _check_number(values, episodes)
    checked("seed", seed, Whole(0, MAX_SEED))
    try:
        combinations = [
            make_case(dict(zip(values, combination, strict=True)))
            for combination in product(*values.values())
        ]
    except ValueError as error:
        raise ParameterError(str(error)) from error
    for name in values:
        if not any(name in case for case in combinations):
            raise ParameterError(f"{name} has no effect here; it applies only {find(name).where}")
    cases = {key_of(case): case for case in combinations}
    return SweepPlan(tuple(cases.values()), episodes, seed)


def spread(name: str, choice: Any) -> list[Value]:
    """Return the checked values of a choice, which is a value, a list or a range."""
    if isinstance(choice, Mapping):
        return [checked(name, value) for value in _range(name, choice)]
    values = choice if isinstance(choice, list) else [choice]
    if not values:
        raise ParameterError(f"{name} has no value; it needs at least one")
    return list(dict.fromkeys(checked(name, value) for value in values))


def _range(name: str, limits: Mapping[str, Any]) -> list[int | float]:
    """Return the numbers of a range, including both ends."""
    if limits.keys() != {"from", "to", "step"}:
        raise ParameterError(f"{name} is {dict(limits)!r}; a range has the keys from, to and step")
    first, last, step = (limits[key] for key in ("from", "to", "step"))
    for key, value in limits.items():
        if type(value) not in (int, float):
            raise ParameterError(f"{name}.{key} is {value!r}; it must be a number")
        if not abs(value) <= MAX_VALUE:
            raise ParameterError(f"{name}.{key} is not within {-MAX_VALUE}..{MAX_VALUE}")
    if not (step > 0 and first <= last):
        raise ParameterError(
            f"{name} goes from {first} to {last} in steps of {step}; the range must increase"
        )
    steps = (last - first) / step + 1e-9
    if steps >= MAX_CASES:
        raise ParameterError(
            f"{name} has {steps + 1:.0f} values; MAX_CASES = {MAX_CASES} are allowed"
        )
    # Rounded to what a user would type, such as 0.3 for 0.1 + 0.2, so that no value occurs twice.
    numbers = (first + step * number for number in range(math.floor(steps) + 1))
    return [each if isinstance(each, int) else float(f"{each:.{DIGITS}g}") for each in numbers]


def _check_number(values: Mapping[str, Sequence[Value]], episodes: int) -> None:
    count = math.prod(map(len, values.values()))
    if count > MAX_CASES:
        longest = max(values, key=lambda name: len(values[name]))
        raise ParameterError(
            f"the plan has {count} combinations, and {longest} has {len(values[longest])} values; "
            f"MAX_CASES = {MAX_CASES} are allowed"
        )
    if count * episodes > MAX_EPISODES:
        raise ParameterError(
            f"episodes is {episodes}; with {count} combinations that makes {count * episodes}, "
            f"and MAX_EPISODES = {MAX_EPISODES} are allowed"
        )
