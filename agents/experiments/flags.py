"""Settings as they are written on a command line: ``battery=20:200:20``, ``escape=on,off``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from agents.experiments.setting import SettingError, find

WORDS: dict[str, bool] = {"on": True, "off": False, "true": True, "false": False}


def parse_flags(flags: Sequence[str]) -> dict[str, Any]:
    """Return the choices that flags stand for.

    Args:
        flags: ``NAME=VALUE``, ``NAME=VALUE,VALUE,...`` or ``NAME=FROM:TO:STEP``.

    Raises:
        SettingError: naming the flag and what is allowed.
    """
    choices: dict[str, Any] = {}
    for flag in flags:
        name, equals, words = flag.partition("=")
        name = name.strip()
        if not equals:
            raise SettingError(f"{flag!r} has no value; write NAME=VALUE")
        find(name)
        if name in choices:
            raise SettingError(f"{name} is given twice; write {name}=VALUE,VALUE")
        choices[name] = _choice(words)
    return choices


def _choice(words: str) -> Any:
    limits = [_value(word) for word in words.split(":")]
    if len(limits) == 3 and all(type(limit) in (int, float) for limit in limits):
        return dict(zip(("from", "to", "step"), limits, strict=True))
    return [_value(word) for word in words.split(",")]


def _value(word: str) -> Any:
    """Return a word as the flag or number that it stands for, or as it is."""
    word = word.strip()
    if word.lower() in WORDS:
        return WORDS[word.lower()]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
