"""What can be varied in an experiment, and which values each parameter takes.

Files and flags are checked against ``PARAMETERS``, and reports name the differences by it. A
parameter that has no effect on a case, such as the escape of an agent that has none, is left out of
the case, so that the same experiment is not run twice under two names.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, NamedTuple

from agents.errors import ParameterError
from agents.fleet.planned import DEFAULT_ASSIGNMENT
from agents.lab.console.place import RANDOM, Stations
from agents.mapf.assignment import ASSIGNMENTS
from warehouse_core.batch.fleet.settings import MAX_BODIES
from warehouse_core.motion import backends
from warehouse_core.wording import printable
from warehouse_core.world.generators import MAX_DENSITY
from warehouse_core.world.named_layouts import DEFAULT

Value = str | int | float | bool

PLANNER, NO_PLANNER = "planner", "none"
"""The parameter that names what directs all robots of a fleet; by default each has an agent."""

FLEET = "robots"
"""The parameter that every case of a fleet has, and no other case."""

MAX_VALUE = 1_000_000_000

MAX_NUMBER = sys.float_info.max

MAX_TEXT = 10_000
"""Most characters of a name."""

MAX_VIEW_RADIUS = 1000
"""Largest view radius in cells: a view takes memory even where there is nothing to see."""


class Parameter(NamedTuple):
    """A quantity that can be varied.

    Attributes:
        default: the value if none is given.
        check: returns a value as it is stored, or raises ``ValueError`` with what is allowed.
        needs: the values of parameters before it without which it has no effect.
        question: the question that varying it answers; the chapter asks some of them.
        of_fleets: ``True`` if it has an effect only on fleets, ``False`` only on lone robots,
            ``None`` on both.
        is_planned: ``True`` if it has an effect only with a planner, ``False`` only without one,
            ``None`` with and without.
    """

    default: Value | None
    check: Callable[[Any], Value]
    needs: Mapping[str, Value] = {}
    question: str = ""
    of_fleets: bool | None = None
    is_planned: bool | None = None

    def applies(self, case: Mapping[str, Any]) -> bool:
        """Return whether it has an effect, given the values of the parameters before it."""
        has_planner = case.get(PLANNER, NO_PLANNER) != NO_PLANNER
        return (
            self.of_fleets in (None, FLEET in case)
            and self.is_planned in (None, has_planner)
            and self.needs.items() <= case.items()
        )

    @property
    def where(self) -> str:
        """Where it has an effect, in words, if not everywhere."""
        if self.is_planned is not None:
            return f"{'with' if self.is_planned else 'without'} a {PLANNER}"
        if self.of_fleets is not None:
            return "to fleets" if self.of_fleets else "to lone robots, without settings of fleets"
        return "with " + " and ".join(
            f"{name}={shown(value)}" for name, value in self.needs.items()
        )


def whole(minimum: int, maximum: int = MAX_VALUE) -> Callable[[Any], int]:
    """Return a check for whole numbers from ``minimum`` to ``maximum``."""

    def check(value: Any) -> int:
        if type(value) is not int or not minimum <= value <= maximum:
            raise ValueError(f"a whole number {minimum}..{maximum}")
        return value

    return check


def number(minimum: float = -MAX_NUMBER, maximum: float = MAX_NUMBER) -> Callable[[Any], float]:
    """Return a check for finite numbers."""

    def check(value: Any) -> float:
        if type(value) not in (int, float) or not minimum <= value <= maximum:
            limits = "" if minimum == -MAX_NUMBER else f" {minimum:g}..{maximum:g}"
            raise ValueError(f"a number{limits}")
        return float(value) + 0.0  # -0.0 becomes 0.0

    return check


def flag(value: Any) -> bool:
    """Check that a value is true or false."""
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def text(value: Any) -> str:
    """Check that a value is text, not blank and not too long."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_TEXT:
        raise ValueError(f"a name of at most MAX_TEXT = {MAX_TEXT} characters")
    return value


def backend(value: Any) -> str:
    """Check that a value names an installed backend."""
    if value not in backends.backend_names():
        raise ValueError(f"one of {', '.join(backends.backend_names())}")
    return str(value)


def assignment(value: Any) -> str:
    """Check that a value names a task assignment."""
    if value not in list(ASSIGNMENTS):
        raise ValueError(f"one of {', '.join(ASSIGNMENTS)}")
    return str(value)


def stations(value: Any) -> str:
    """Check that a value says where pickup and dropoff come from."""
    if value not in list(Stations):
        raise ValueError(" or ".join(Stations))
    return str(value)


def due_times(value: Any) -> str:
    """Check that a value is the fewest and the most steps until an order is due."""
    found = re.fullmatch(r"(0|[1-9]\d{0,8}):(0|[1-9]\d{0,8})", str(value))
    if found is None or int(found[1]) > int(found[2]):
        raise ValueError('"FEWEST:MOST" steps, such as "50:150"')
    return found[0]


def size(value: Any) -> str:
    """Check that a value is a height and a width such as ``7x12``."""
    found = re.fullmatch(r"([1-9]\d{0,3})x([1-9]\d{0,3})", str(value))
    if found is None or min(map(int, found.groups())) < 4:
        raise ValueError('a size "HEIGHTxWIDTH" of at least 4x4, such as "7x12"')
    return found[0]


PARAMETERS = {
    FLEET: Parameter(
        8, whole(1, MAX_BODIES), question="How many robots are too many?", of_fleets=True
    ),
    PLANNER: Parameter(
        NO_PLANNER, text, question="Which planner does best?", of_fleets=True
    ),
    "assignment": Parameter(
        DEFAULT_ASSIGNMENT, assignment, question="How should orders be assigned?",
        of_fleets=True, is_planned=True,
    ),
    "agent": Parameter("greedy", text, question="Which agent does best?", is_planned=False),
    "escape": Parameter(
        True, flag, {"agent": "greedy"},
        "Does escaping loops cut delivery time, or does it make the robot wander?",
    ),
    "memory": Parameter(
        10, whole(0), {"agent": "greedy", "escape": True},
        "How much should an agent remember to notice a loop?",
    ),
    "layout": Parameter(DEFAULT, text, question="Which layout is hardest?"),
    "size": Parameter(
        "7x12", size, {"layout": RANDOM}, "What does a larger grid do?"
    ),
    "density": Parameter(
        0.2, number(0, MAX_DENSITY), {"layout": RANDOM},
        "What do more obstacles do?",
    ),
    "stations": Parameter(  # for a layout file its default is another, see case.py
        str(Stations.DRAWN), stations,
        question="What do random pickups and dropoffs change?", of_fleets=False,
    ),
    "order_rate": Parameter(
        0.06, number(0, MAX_VALUE), question="How many orders can the fleet carry out?",
        of_fleets=True,
    ),
    "due": Parameter(
        "50:150", due_times, question="What do earlier due times change?", of_fleets=True
    ),
    "chargers": Parameter(  # by default as many as the layout has, see case.py
        0, whole(0), question="How many chargers does the fleet need?", of_fleets=True
    ),
    "people": Parameter(
        0, whole(0, MAX_BODIES), question="What do people on the floor change?", of_fleets=True
    ),
    "battery": Parameter(
        200, whole(1), question="How does battery capacity affect success?"
    ),
    "max_steps": Parameter(200, whole(1), question="How long should an episode be?"),
    "view_radius": Parameter(
        2, whole(0, MAX_VIEW_RADIUS), question="What does it help to see further?"
    ),
    "backend": Parameter(
        "grid", backend, question="What does the real robot do with the same policy?"
    ),
}  # fmt: skip

PHYSICAL = {"robot": "RobotSpec", "disturbances": "Disturbances"}
"""Groups of parameters of the physics backend, and the class that has them as fields."""


def find(name: str) -> Parameter:
    """Return a parameter by its name, such as ``battery`` or ``robot.mass``.

    Raises:
        ParameterError: there is none; the message lists those that there are.
    """
    if name in PARAMETERS:
        return PARAMETERS[name]
    group, _, field = name.partition(".")
    if group in PHYSICAL:
        allowed = field_defaults(group)
        if field in allowed:
            return Parameter(allowed[field], number(), {"backend": "physics"})
        raise ParameterError(f"{group} has no {field!r}; allowed: {', '.join(allowed)}")
    names = [*PARAMETERS, *(f"{group}.NAME" for group in PHYSICAL)]
    raise ParameterError(f"no setting is called {name!r}; allowed: {', '.join(names)}")


def field_defaults(group: str) -> dict[str, float]:
    """Return the numeric fields of ``RobotSpec`` or ``Disturbances`` with their defaults.

    Raises:
        BackendError: the physics backend is not installed.
    """
    backends.load_backend("physics")
    import warehouse_physics

    kind: Any = getattr(warehouse_physics, PHYSICAL[group])
    return {each.name: each.default for each in fields(kind) if isinstance(each.default, float)}


def checked(name: str, value: Any, check: Callable[[Any], Value] | None = None) -> Value:
    """Return a value of a parameter as it is stored.

    Args:
        name: name of the parameter.
        value: value to check.
        check: used instead of the parameter's own check.

    Raises:
        ParameterError: the value is not allowed; the message says what is.
    """
    check = check or find(name).check
    try:
        return check(value)
    except ValueError as error:
        raise ParameterError(f"{name} is {value!r}; allowed: {error}") from None


def shown(value: Value | None) -> str:
    """Return a value as text that can be written."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else printable(str(value))
