"""The settings of episodes, each declared once with its default, range and description.

Options, rubrics, plans of sweeps and files of results are checked against ``PARAMETERS``, and
reports use its names for what differs. A case leaves out every parameter that has no effect on it,
such as the escape of an agent that has none. Otherwise the same experiment could run twice under
two names.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from agents.errors import ParameterError
from agents.fleet.planned import DEFAULT_ASSIGNMENT
from agents.lab.place import RANDOM, Stations
from agents.mapf.assignment import ASSIGNMENTS
from warehouse_core.arguments import MAX_VIEW_RADIUS
from warehouse_core.batch.fleet_settings import MAX_BODIES
from warehouse_core.motion import backends
from warehouse_core.wording import printable
from warehouse_core.world.generators import MAX_DENSITY
from warehouse_core.world.named_layouts import DEFAULT

Value = str | int | float | bool

PLANNER, NO_PLANNER = "planner", "none"
"""Name and default of the parameter that selects the planner of a fleet.

By default each robot of a fleet has an agent.
"""

FLEET = "robots"
"""Name of the parameter that every case of a fleet has, and no other case."""

MAX_VALUE = 1_000_000_000
"""Largest battery capacity and number of steps, which records store as 64-bit numbers."""

MAX_SEED = 2**62
"""Largest seed of a first episode; files of results store seeds as 64-bit numbers."""

MAX_NUMBER = sys.float_info.max

MAX_TEXT = 10_000
"""Maximum number of characters in a name."""


class Parameter(NamedTuple):
    """A setting that can be varied, as used by options, rubrics, sweeps and exports.

    Attributes:
        default: Value if none is given.
        check: Function that returns a value in the form in which it is stored, or raises
            ``ValueError`` with a description of the allowed values.
        values: Allowed values in words; ``{}`` stands for the range of the check.
        needs: Values of earlier parameters without which this one has no effect.
        question: Question that varying it answers; the chapter asks some of them.
        of_fleets: ``True`` if it affects only fleets, ``False`` if it affects only lone robots, and
            ``None`` if it affects both.
        is_planned: ``True`` if it has an effect only with a planner, ``False`` if only without one,
            and ``None`` if in both cases.
        help: Description of its option.
    """

    default: Value | None
    check: Callable[[Any], Value]
    values: str = "{}"
    needs: Mapping[str, Value] = {}
    question: str = ""
    of_fleets: bool | None = None
    is_planned: bool | None = None
    help: str = ""

    def applies(self, case: Mapping[str, Any]) -> bool:
        """Return whether it has an effect, given the values of all earlier parameters."""
        has_planner = case.get(PLANNER, NO_PLANNER) != NO_PLANNER
        return (
            self.of_fleets in (None, FLEET in case)
            and self.is_planned in (None, has_planner)
            and self.needs.items() <= case.items()
        )

    @property
    def where(self) -> str:
        """Condition under which it has an effect, in words that follow "it applies only"."""
        if self.is_planned is not None:
            return f"{'with' if self.is_planned else 'without'} a {PLANNER}"
        if self.of_fleets is not None:
            return "to fleets" if self.of_fleets else "to lone robots, without settings for fleets"
        return "with " + " and ".join(
            f"{name}={shown(value)}" for name, value in self.needs.items()
        )


@dataclass(frozen=True)
class Whole:
    """A check for whole numbers from ``minimum`` to ``maximum``."""

    minimum: int
    maximum: int = MAX_VALUE

    def __call__(self, value: Any) -> int:
        """Return an allowed value, or raise ``ValueError`` with the range."""
        if type(value) is not int or not self.minimum <= value <= self.maximum:
            raise ValueError(f"a whole number {self}")
        return value

    def __str__(self) -> str:
        """The range."""
        return f"{self.minimum}..{self.maximum}"


CheckValue = Callable[[Any], Any]
"""Function that converts a value, or raises ``ValueError`` with what is allowed."""


@dataclass(frozen=True)
class Number:
    """A check for finite numbers from ``minimum`` to ``maximum``."""

    minimum: float = -MAX_NUMBER
    maximum: float = MAX_NUMBER

    def __call__(self, value: Any) -> float:
        """Return an allowed value as a ``float``, and 0.0 for -0.0."""
        if type(value) not in (int, float) or not self.minimum <= value <= self.maximum:
            raise ValueError("a number" if self == Number() else f"a number {self}")
        return float(value) + 0.0

    def __str__(self) -> str:
        """The range."""
        return f"{self.minimum:g}..{self.maximum:g}"


def flag(value: Any) -> bool:
    """Check that a value is true or false."""
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def text(value: Any) -> str:
    """Check that a value is text that is neither blank nor too long."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_TEXT:
        raise ValueError(f"a name of at most MAX_TEXT = {MAX_TEXT} characters")
    return value


def one_of(*allowed: str, joint: str = ", ", before: str = "") -> Callable[[Any], str]:
    """Return a check for one of some words; its error lists the allowed words."""

    def check(value: Any) -> str:
        if value not in allowed:
            raise ValueError(before + joint.join(allowed))
        return str(value)

    return check


def backend(value: Any) -> str:
    """Check that a value names an installed backend."""
    return one_of(*backends.backend_names(), before="one of ")(value)


def due_times(value: Any) -> str:
    """Check that a value gives the fewest and the most steps from release to due time."""
    times = re.fullmatch(r"(0|[1-9]\d{0,8}):(0|[1-9]\d{0,8})", str(value))
    if times is None or int(times[1]) > int(times[2]):
        raise ValueError('"FEWEST:MOST" steps, such as "50:150"')
    return times[0]


def size(value: Any) -> str:
    """Check that a value is a height and a width, such as ``7x12``."""
    sides = re.fullmatch(r"([1-9]\d{0,3})x([1-9]\d{0,3})", str(value))
    if sides is None or min(map(int, sides.groups())) < 4:
        raise ValueError('a size "HEIGHTxWIDTH" of at least 4x4, such as "7x12"')
    return sides[0]


def pair_of(checked_text: str) -> tuple[int, int]:
    """Return the two numbers of a text that ``due_times`` or ``size`` has checked."""
    first, second = map(int, re.split("[:x]", checked_text))
    return first, second


PARAMETERS = {
    FLEET: Parameter(
        8, Whole(1, MAX_BODIES), "{}; makes it a fleet with orders",
        question="How many robots are too many?", of_fleets=True, help="Number of robots.",
    ),
    PLANNER: Parameter(
        NO_PLANNER, text, "none, or as in 'warehouse fleet', for fleets",
        question="Which planner does best?", of_fleets=True,
    ),
    "assignment": Parameter(
        DEFAULT_ASSIGNMENT, one_of(*ASSIGNMENTS, before="one of "),
        ", ".join(ASSIGNMENTS),
        question="How should orders be assigned?", of_fleets=True, is_planned=True,
        help=f"How a planner assigns orders to robots: {', '.join(ASSIGNMENTS)}. "
        f"Default: {DEFAULT_ASSIGNMENT}.",
    ),
    "agent": Parameter(
        "greedy", text, "a name as in 'warehouse run'",
        question="Which agent does best?", is_planned=False,
    ),
    "escape": Parameter(
        True, flag, "on or off, for agent greedy", {"agent": "greedy"},
        "Does escaping loops cut delivery time, or does it make the robot wander?",
    ),
    "memory": Parameter(
        10, Whole(0), "{}, for agent greedy", {"agent": "greedy", "escape": True},
        "How much should an agent remember to notice a loop?",
        help="Number of positions that the greedy agent remembers. Default: 10.",
    ),
    "layout": Parameter(
        DEFAULT, text, "a file, a name, or random", question="Which layout is hardest?"
    ),
    "size": Parameter(
        "7x12", size, "HEIGHTxWIDTH, for layout random", {"layout": RANDOM},
        "What is the effect of a larger grid?",
    ),
    "density": Parameter(
        0.2, Number(0, MAX_DENSITY), "{}, for layout random", {"layout": RANDOM},
        "What is the effect of more obstacles?",
    ),
    "stations": Parameter(  # layout files have another default, see case.py
        str(Stations.DRAWN), one_of(*Stations, joint=" or "),
        "drawn or kept, for lone robots",
        question="What do random pickups and dropoffs change?", of_fleets=False,
    ),
    "order_rate": Parameter(
        0.06, Number(0, MAX_VALUE), "mean number of orders per step, for fleets",
        question="How many orders can the fleet carry out?", of_fleets=True,
        help="Mean number of orders that arrive in a step.",
    ),
    "due": Parameter(
        "50:150", due_times, "FEWEST:MOST steps, for fleets",
        question="What is the effect of earlier due times?", of_fleets=True,
        help="Steps from the release of an order to its due time.",
    ),
    "chargers": Parameter(  # by default as many as the layout has, see case.py
        0, Whole(0), "at most those in the layout, for fleets",
        question="How many chargers does the fleet need?", of_fleets=True,
    ),
    "people": Parameter(
        0, Whole(0, MAX_BODIES), "{}, for fleets",
        question="What is the effect of people on the floor?", of_fleets=True,
        help="Number of people who walk on the floor.",
    ),
    "battery": Parameter(
        200, Whole(1), question="How does battery capacity affect success?",
        help="Number of steps that a full battery lasts.",
    ),
    "max_steps": Parameter(
        200, Whole(1), question="How long should an episode be?",
        help="Maximum number of steps in an episode.",
    ),
    "view_radius": Parameter(
        2, Whole(0, MAX_VIEW_RADIUS), question="How much does it help to see farther?",
        help=f"Number of cells that the robot sees in each direction, up to {MAX_VIEW_RADIUS}.",
    ),
    "backend": Parameter(
        "grid", backend, "grid or physics, and driving for fleets",
        question="What does the real robot do with the same policy?",
    ),
}  # fmt: skip

PHYSICAL = {"robot": "RobotSpec", "disturbances": "Disturbances"}
"""Groups of parameters of the physics backend, and the class whose fields each group sets."""


def default_value(name: str) -> Any:
    """Return the default of a parameter."""
    return PARAMETERS[name].default


def find(name: str) -> Parameter:
    """Return a parameter by its name, such as ``battery`` or ``robot.mass``.

    Raises:
        ParameterError: there is no such parameter; the message lists all names.
    """
    if name in PARAMETERS:
        return PARAMETERS[name]
    group, _, field = name.partition(".")
    if group in PHYSICAL:
        allowed = field_defaults(group)
        if field in allowed:
            return Parameter(allowed[field], Number(), needs={"backend": "physics"})
        raise ParameterError(f"{group} has no {field!r}; allowed: {', '.join(allowed)}")
    names = [*PARAMETERS, *(f"{group}.NAME" for group in PHYSICAL)]
    raise ParameterError(f"no setting is called {name!r}; allowed: {', '.join(names)}")


def field_defaults(group: str) -> dict[str, float]:
    """Return the numeric fields of ``RobotSpec`` or ``Disturbances`` and their defaults.

    Raises:
        BackendError: the physics backend is not installed.
    """
    backends.load_backend("physics")
    import warehouse_physics

    kind: Any = getattr(warehouse_physics, PHYSICAL[group])
    return {each.name: each.default for each in fields(kind) if isinstance(each.default, float)}


def checked(name: str, value: Any, check: Callable[[Any], Value] | None = None) -> Value:
    """Check a value of a parameter and return it in the form in which it is stored.

    Args:
        name: name of the parameter.
        value: value to check.
        check: check to use instead of the parameter's own.

    Raises:
        ParameterError: the value is not allowed; the message says which values are.
    """
    check = check or find(name).check
    try:
        return check(value)
    except ValueError as error:
        raise ParameterError(f"{name} is {value!r}; allowed: {error}") from None


def shown(value: Value | None) -> str:
    """Return a value as printable text."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else printable(str(value))
