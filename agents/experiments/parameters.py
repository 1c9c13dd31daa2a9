"""What can be varied in an experiment, and which values each setting takes.

``SETTINGS`` is the one list of them: files and flags are checked against it, and reports name what
differs by it. A setting that means nothing for a case, such as the escape of an agent that has
none, is left out of the case, so that the same experiment is not run twice under two names.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from agents.errors import ParameterError
from warehouse_core.motion import backends
from warehouse_core.world.generators import MAX_DENSITY

Value = str | int | float | bool

DEFAULT, RANDOM = "default", "random"
"""Layouts by name: the chapter's, and one made up for each seed. Any other is a file."""

MOST = 1_000_000_000

MAX_VIEW_RADIUS = 1000
"""A view of so many cells takes memory, whether there is anything to see or not."""


def always(case: Mapping[str, Value]) -> bool:
    """Say that a setting counts in every case."""
    return True


def is_greedy(case: Mapping[str, Value]) -> bool:
    """Say whether the agent is the one with a memory and an escape."""
    return case["agent"] == "greedy"


def escapes(case: Mapping[str, Value]) -> bool:
    """Say whether the agent has an escape, the only use there is of its memory."""
    return is_greedy(case) and case["escape"] is True


def is_random(case: Mapping[str, Value]) -> bool:
    """Say whether layouts are made up."""
    return case["layout"] == RANDOM


def is_physical(case: Mapping[str, Value]) -> bool:
    """Say whether moves are motions of a rigid body."""
    return case["backend"] == "physics"


@dataclass(frozen=True, slots=True)
class Setting:
    """One thing that can be varied.

    Attributes:
        default: the value where none is given; ``None`` leaves it to whatever takes it.
        check: returns a value as it is kept, or raises ``ValueError`` with what is allowed.
        counts: says for the settings before this one whether it means anything.
        needs: the same in words.
        help: what it is.
        question: what is asked where it is varied; the chapter asks some of them.
    """

    default: Value | None
    check: Callable[[Any], Value]
    help: str
    counts: Callable[[Mapping[str, Value]], bool] = always
    needs: str = ""
    question: str = ""


def whole(least: int, most: int = MOST) -> Callable[[Any], int]:
    """Return a check for whole numbers from ``least`` to ``most``."""

    def check(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ValueError(f"a whole number {least}..{most}")
        return value

    return check


def number(least: float = -math.inf, most: float = math.inf) -> Callable[[Any], float]:
    """Return a check for finite numbers."""

    def check(value: Any) -> float:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not abs(value) <= sys.float_info.max or not least <= value <= most:
            limits = "" if least == -math.inf else f" {least:g}..{most:g}"
            raise ValueError(f"a number{limits}")
        return float(value) + 0.0  # there is no minus nought

    return check


def flag(value: Any) -> bool:
    """Check that a value is true or false."""
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def text(value: Any) -> str:
    """Check that a value is text, and not empty."""
    if not isinstance(value, str) or not value.strip():
        raise ValueError("a name")
    return value


def backend(value: Any) -> str:
    """Check that a value names an installed backend."""
    if not isinstance(value, str) or value not in backends.backend_names():
        raise ValueError(f"one of {', '.join(backends.backend_names())}")
    return value


def size(value: Any) -> str:
    """Check that a value is a height and a width such as ``7x12``."""
    found = (
        re.fullmatch(r"([1-9]\d{0,3})x([1-9]\d{0,3})", value) if isinstance(value, str) else None
    )
    if found is None or min(map(int, found.groups())) < 4:
        raise ValueError('a size "HEIGHTxWIDTH" of at least 4x4, such as "7x12"')
    return found[0]


SETTINGS: dict[str, Setting] = {
    "agent": Setting(
        "greedy", text, "the agent, as for warehouse run",
        question="Which agent does best?",
    ),
    "escape": Setting(
        True, flag, "whether the greedy agent escapes from loops", is_greedy,
        "with agent=greedy",
        "Does escaping loops cut delivery time, or does it make the robot wander?",
    ),
    "memory": Setting(
        10, whole(0), "positions that the greedy agent remembers", escapes,
        "with agent=greedy and escape=on",
        "How much should an agent remember to notice a loop?",
    ),
    "layout": Setting(
        DEFAULT, text, f'"{DEFAULT}", "{RANDOM}" or a file',
        question="Which layout is hardest?",
    ),
    "size": Setting(
        "7x12", size, "height x width of random layouts", is_random,
        "with layout=random",
        "What does a larger grid do?",
    ),
    "density": Setting(
        0.2, number(0, MAX_DENSITY), "walls of random layouts", is_random,
        "with layout=random",
        "What do more obstacles do?",
    ),
    "battery": Setting(
        200, whole(1), "units of a full battery",
        question="How does battery capacity affect success?",
    ),
    "max_steps": Setting(
        200, whole(1), "steps of an episode",
        question="How long should an episode be?",
    ),
    "view_radius": Setting(
        2, whole(0, MAX_VIEW_RADIUS), "cells seen in each direction",
        question="What does it help to see further?",
    ),
    "backend": Setting(
        "grid", backend, "what carries out the moves",
        question="What does the real robot do with the same policy?",
    ),
}  # fmt: skip

ROBOT, DISTURBANCES = "robot", "disturbances"
PHYSICAL = {
    ROBOT: "RobotSpec",
    DISTURBANCES: "Disturbances",
}
"""Groups of settings of the physics backend, and the class whose numbers they are."""


def find(name: str) -> Setting:
    """Return a setting by its name, ``battery`` or ``robot.mass``.

    Raises:
        ParameterError: listing what there is.
    """
    if name in SETTINGS:
        return SETTINGS[name]
    group, _, field = name.partition(".")
    if group in PHYSICAL:
        allowed = field_defaults(group)
        if field in allowed:
            about = f"of {PHYSICAL[group]}"
            return Setting(allowed[field], number(), about, is_physical, "with backend=physics")
        raise ParameterError(f"{group} has no {field!r}; allowed: {', '.join(allowed)}")
    groups = [f"{group}.NAME" for group in PHYSICAL]
    raise ParameterError(
        f"no setting is called {name!r}; allowed: {', '.join([*SETTINGS, *groups])}"
    )


def field_defaults(group: str) -> dict[str, float]:
    """Return the numbers of ``RobotSpec`` or of ``Disturbances`` by name, each with its default.

    Raises:
        BackendError: the physics backend is not installed.
    """
    backends.load_backend("physics")
    import warehouse_physics

    kind: Any = getattr(warehouse_physics, PHYSICAL[group])
    return {each.name: each.default for each in fields(kind) if isinstance(each.default, float)}


def checked(name: str, value: Any) -> Value:
    """Return a value of a setting as it is kept.

    Raises:
        ParameterError: naming the setting, the value and what is allowed.
    """
    setting = find(name)
    try:
        return setting.check(value)
    except ValueError as error:
        raise ParameterError(f"{name} is {value!r}; allowed: {error}") from None


def shown(value: Value | None) -> str:
    """Return a value as it is written for a reader."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)
