"""The values to run, as a TOML file and as flags, checked before anything runs.

A plan file has these keys, all of them optional::

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

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from agents.errors import ParameterError
from agents.lab.parameters import MAX_SEED, PHYSICAL, Whole, checked, find

MAX_BYTES = 100_000
"""Limit on a plan file. The time to parse TOML grows with the square of a key's depth, so that is
limited too, and so is a line, in which a key must end."""

MAX_LINE = 2_000
"""Limit on the bytes of a line of a plan file."""

MAX_DEPTH = 10
"""Limit on the parts of a key, ``robot.mass`` has two; a name may have as many dots in a row."""

_DEEP = re.compile(rf"""(?<![\w-])((?:[\w-]++|"[^"]*+"|'[^']*+')[ \t]*+\.[ \t]*+){{{MAX_DEPTH}}}""")

NUMBERS = {"episodes": Whole(1), "seed": Whole(0, MAX_SEED)}

WORDS: dict[str, bool] = {"on": True, "off": False, "true": True, "false": False}


class PlanFile(NamedTuple):
    """The value, list of values or range of each parameter, and two numbers if they are given."""

    choices: dict[str, Any]
    episodes: int | None = None
    seed: int | None = None


def read_plan_file(path: Path) -> PlanFile:
    """Read a plan file; a ``ParameterError`` names the file, the key and what is allowed."""
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise ParameterError(f"{path}: it is longer than MAX_BYTES = {MAX_BYTES}")
    try:
        _check_lines(data)
        return _parse(tomllib.loads(data.decode("utf-8-sig")))
    except (ValueError, RecursionError) as error:
        raise ParameterError(f"{path}: {error}") from error


def _check_lines(data: bytes) -> None:
    for number, line in enumerate(data.split(b"\n"), start=1):
        if len(line) > MAX_LINE:
            raise ParameterError(f"line {number} is longer than MAX_LINE = {MAX_LINE} bytes")
        if _DEEP.search(line.decode(errors="replace")):
            raise ParameterError(
                f"line {number} has a key of more than MAX_DEPTH = {MAX_DEPTH} parts"
            )


def _parse(content: Mapping[str, Any]) -> PlanFile:
    allowed = [*NUMBERS, "settings", *PHYSICAL]
    unknown = [key for key in content if key not in allowed]
    if unknown:
        raise ParameterError(f"unknown key {unknown[0]!r}; allowed: {', '.join(allowed)}")
    choices: dict[str, Any] = {}
    for group in ("settings", *PHYSICAL):
        table = content.get(group, {})
        if not isinstance(table, dict):
            raise ParameterError(f"{group} is {table!r}; it must be a table, [{group}]")
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
    """Return the choices of ``NAME=VALUE``, ``NAME=VALUE,VALUE,...`` or ``NAME=FROM:TO:STEP``."""
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
    """Return a word as a flag or a number if it is one, else as text."""
    word = word.strip()
    if word.lower() in WORDS:
        return WORDS[word.lower()]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
