"""The values to run, read from a TOML file and from flags, and checked before anything runs.

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

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from agents.errors import ParameterError
from agents.lab.parameters import MAX_SEED, PHYSICAL, Whole, checked, find
from agents.lab.toml_text import MAX_BYTES, parse_toml
from warehouse_core.files.reading import read_file
from warehouse_core.wording import brief

__all__ = ["PlanFile", "parse_flags", "read_plan_file"]

NUMBERS = {"episodes": Whole(1), "seed": Whole(0, MAX_SEED)}

WORDS: dict[str, bool] = {"on": True, "off": False, "true": True, "false": False}


class PlanFile(NamedTuple):
    """The contents of a plan file.

    Attributes:
        choices: value, list of values or range for each parameter.
        episodes: number of episodes of each combination, if the file has it.
        seed: first seed, if the file has it.

    Example:
        >>> from agents.lab.experiments.choices import PlanFile
        >>> PlanFile({"memory": [5, 10]}, episodes=20)
        PlanFile(choices={'memory': [5, 10]}, episodes=20, seed=None)
    """

    choices: dict[str, Any]
    episodes: int | None = None
    seed: int | None = None


def read_plan_file(path: Path) -> PlanFile:
    """Read a plan file.

    Raises:
        ParameterError: the file is not a plan. The message names the file, the key and what is
            allowed.
        OSError: the file cannot be read, or is longer than ``toml_text.MAX_BYTES``.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.experiments.choices import read_plan_file
        >>> size = Path("plan.toml").write_text("episodes = 20")
        >>> read_plan_file(Path("plan.toml")).episodes
        20
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
    choices: dict[str, Any] = {}
    for group in ("settings", *PHYSICAL):
        table = content.get(group, {})
        if not isinstance(table, dict):
            raise ParameterError(f"{group} is {brief(table)}; it must be a table, [{group}]")
        for key, choice in table.items():
            name = key if group == "settings" else f"{group}.{key}"
            find(name)
            if name in choices:
                raise ParameterError(f"{name} is given twice")
            choices[name] = choice
    numbers: dict[str, Any] = {
        key: checked(key, content[key], check) for key, check in NUMBERS.items() if key in content
    }
    return PlanFile(choices, **numbers)


def parse_flags(flags: Sequence[str]) -> dict[str, Any]:
    """Parse flags such as ``NAME=VALUE``, ``NAME=VALUE,VALUE,...`` and ``NAME=FROM:TO:STEP``.

    Returns:
        Value, list of values or range for each name.

    Example:
        >>> from agents.lab.experiments.choices import parse_flags
        >>> parse_flags(["escape=on,off", "battery=40:200:80"])
        {'escape': [True, False], 'battery': {'from': 40, 'to': 200, 'step': 80}}
    """
    choices: dict[str, Any] = {}
    for flag in flags:
        name, equals, words = flag.partition("=")
        name = name.strip()
        if not equals:
            raise ParameterError(f"{flag!r} has no value; write NAME=VALUE")
        find(name)
        if name in choices:
            raise ParameterError(f"{name} is given twice; write {name}=VALUE,VALUE")
        choices[name] = _choice(words)
    return choices


def _choice(words: str) -> Any:
    limits = [_value(word) for word in words.split(":")]
    if len(limits) == 3 and all(type(limit) in (int, float) for limit in limits):
        return dict(zip(("from", "to", "step"), limits, strict=True))
    return [_value(word) for word in words.split(",")]


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
