"""The plan of a sweep, read from a TOML file and from flags, and checked before anything runs.

A plan file has these keys, all of which are optional::

    episodes = 200
    seed = 0

    [settings]
    escape = [true, false]
    battery = { from = 20, to = 200, step = 20 }
    backend = ["grid", "physics"]

    [robot]
    mass = [50, 70]

    [disturbances]
    motor_strength = [1.0, 0.5]
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from agents.errors import ParameterError
from agents.lab.experiments.case import Case, key_of, make_case
from agents.lab.parameters import MAX_SEED, MAX_VALUE, PHYSICAL, Number, Value, Whole, checked, find
from agents.lab.toml_text import MAX_BYTES, parse_toml
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief

MAX_CASES = 10_000
MAX_EPISODES = 100_000_000

NUMBERS = {"episodes": Whole(1), "seed": Whole(0, MAX_SEED)}

WORDS: dict[str, bool] = {"on": True, "off": False, "true": True, "false": False}

RANGE = ("from", "to", "step")
"""Keys of a range."""

DIGITS = 12
"""Significant digits of the numbers in a range."""


class PlanFile(NamedTuple):
    """The contents of a plan file.

    Attributes:
        choices: value, list of values or range for each parameter.
        episodes: number of episodes of each combination, if the file has it.
        seed: first seed, if the file has it.
    """

    choices: dict[str, Any]
    episodes: int | None = None
    seed: int | None = None


class SweepPlan(NamedTuple):
    """The episodes to run: ``episodes`` of each case, with seeds ``seed``, ``seed + 1``, ..."""

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


def read_plan_file(path: Path) -> PlanFile:
    """Read a plan file.

    Raises:
        ParameterError: the file is not a plan. The message names the file, the key and what is
            allowed.
        OSError: the file cannot be read, or is longer than ``toml_text.MAX_BYTES``.
    """
    data = read_file(path, MAX_BYTES)
    try:
        return _parse(parse_toml(data))
    except ValueError as error:
        raise ParameterError(f"{path}: {error}") from error


def _parse(content: Mapping[str, Any]) -> PlanFile:
    allowed = [*NUMBERS, "settings", *PHYSICAL]
    unknown = [key for key in content if key not in allowed]
    if unknown:
        raise ParameterError(f"unknown key {brief(unknown[0])}; allowed: {', '.join(allowed)}")
    tables = {group: content.get(group, {}) for group in ("settings", *PHYSICAL)}
    for group, table in tables.items():
        if not isinstance(table, dict):
            raise ParameterError(f"{group} is {brief(table)}; it must be a table, [{group}]")
    choices = {
        key if group == "settings" else f"{group}.{key}": choice
        for group, table in tables.items()
        for key, choice in table.items()
    }
    numbers: dict[str, Any] = {
        key: checked(key, content[key], check) for key, check in NUMBERS.items() if key in content
    }
    return PlanFile(choices, **numbers)


def parse_flags(flags: Sequence[str]) -> dict[str, Any]:
    """Parse flags such as ``NAME=VALUE``, ``NAME=VALUE,VALUE,...`` and ``NAME=FROM:TO:STEP``.

    Returns:
        List of values or range for each name.
    """
    choices: dict[str, Any] = {}
    for flag in flags:
        name, equals, words = flag.partition("=")
        name = name.strip()
        if not equals:
            raise ParameterError(f"{flag!r} has no value; write NAME=VALUE")
        if name in choices:
            raise ParameterError(f"{name} is given twice; write {name}=VALUE,VALUE")
        limits = [_value(word) for word in words.split(":")]
        is_range = len(limits) == 3 and all(type(limit) in (int, float) for limit in limits)
        values = [_value(word) for word in words.split(",")]
        choices[name] = dict(zip(RANGE, limits, strict=True)) if is_range else values
    return choices


def _value(word: str) -> Any:
    """Return a word as a Boolean or a number if it is one, else as text."""
    word = word.strip()
    if word.lower() in WORDS:
        return WORDS[word.lower()]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word


def make_plan(choices: Mapping[str, Any], episodes: int, seed: int) -> SweepPlan:
    """Return the plan with every combination of the choices.

    Args:
        choices: value, list of values or range ``{from, to, step}`` for each parameter.
        episodes: number of episodes of each combination.
        seed: seed of the first episode of each combination.

    Raises:
        ParameterError: a value cannot be used, or the plan is too large.
    """
    values = {name: spread(name, choice) for name, choice in choices.items()}
    count = math.prod(map(len, values.values()))
    if count > MAX_CASES:
        raise ParameterError(
            f"the plan has {count} combinations; MAX_CASES = {MAX_CASES} are allowed"
        )
    checked("seed", seed, NUMBERS["seed"])
    try:
        combinations = product(*values.values())
        cases = [make_case(dict(zip(values, each, strict=True))) for each in combinations]
    except ValueError as error:
        raise ParameterError(str(error)) from error
    for name in values:
        if not any(name in case for case in cases):
            raise ParameterError(f"{name} has no effect here; it applies only {find(name).where}")
    different = {key_of(case): case for case in cases}
    return SweepPlan(tuple(different.values()), episodes, seed)


def spread(name: str, choice: Any) -> list[Value]:
    """Return the checked values of a choice, which is a value, a list or a range."""
    if isinstance(choice, Mapping):
        choice = _range(name, choice)
    values = choice if isinstance(choice, list) else [choice]
    if not values:
        raise ParameterError(f"{name} has no value; it needs at least one")
    return list(dict.fromkeys(checked(name, value) for value in values))


def _range(name: str, limits: Mapping[str, Any]) -> list[int | float]:
    """Return the numbers of a range, including both ends."""
    if limits.keys() != {*RANGE}:
        raise ParameterError(f"{name} is {dict(limits)!r}; a range has the keys from, to and step")
    for key, value in limits.items():
        checked(f"{name}.{key}", value, Number(-MAX_VALUE, MAX_VALUE))
    first, last, step = (limits[key] for key in RANGE)
    steps = (last - first) / step + 1e-9 if step > 0 else -1.0
    if not 0 <= steps < MAX_CASES:
        raise ParameterError(
            f"{name} goes from {first} to {last} in steps of {step}; a range must increase and "
            f"have at most MAX_CASES = {MAX_CASES} values"
        )
    # Rounded to what a user would type, such as 0.3 for 0.1 + 0.2, so that no value occurs twice.
    numbers = (first + step * number for number in range(math.floor(steps) + 1))
    return [each if isinstance(each, int) else float(f"{each:.{DIGITS}g}") for each in numbers]
