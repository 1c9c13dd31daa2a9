"""The settings of episodes, each declared once: values, default, range and words.

Options, rubrics, plans of sweeps and files of results are checked against ``PARAMETERS``, and
reports name the differences by it. A parameter that has no effect on a case, such as the escape of
an agent that has none, is left out of the case, so that the same experiment is not run twice under
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
"""The parameter that names what directs all robots of a fleet; by default each has an agent."""

FLEET = "robots"
"""The parameter that every case of a fleet has, and no other case."""

MAX_VALUE = 1_000_000_000
"""Largest battery and number of steps; records keep them as 64-bit numbers."""

MAX_SEED = 2**62
"""Largest seed of the first episode; files of results store seeds as 64-bit numbers."""

MAX_NUMBER = sys.float_info.max

MAX_TEXT = 10_000
"""Most characters of a name."""


class Parameter(NamedTuple):
    """A quantity that can be varied: declared here for options, rubrics, sweeps and exports.

    Attributes:
        default: Value if none is given.
        check: Function that returns a value as it is stored, or raises ``ValueError`` with what is
            allowed.
        values: Values that it takes, in words; ``{}`` stands for the range of the check.
        needs: Values of parameters before it without which it has no effect.
        question: Question that varying it answers; the chapter asks some of them.
        of_fleets: ``True`` if it has an effect only on fleets, ``False`` only on lone robots,
            ``None`` on both.
        is_planned: ``True`` if it has an effect only with a planner, ``False`` only without one,
            ``None`` with and without.
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


@dataclass(frozen=True)
class Whole:
    """A check for whole numbers from ``minimum`` to ``maximum``."""

    minimum: int
    maximum: int = MAX_VALUE

    def __call__(self, value: Any) -> int:
        """Return a value that is allowed."""
        if type(value) is not int or not self.minimum <= value <= self.maximum:
            raise ValueError(f"a whole number {self}")
        return value

    def __str__(self) -> str:
        """The range."""
        return f"{self.minimum}..{self.maximum}"


CheckValue = Callable[[Any], Any]
"""Returns a value as it is used, or raises ``ValueError`` with what is allowed."""


@dataclass(frozen=True)
class Number:
    """A check for finite numbers from ``minimum`` to ``maximum``."""

    minimum: float = -MAX_NUMBER
    maximum: float = MAX_NUMBER

    def __call__(self, value: Any) -> float:
        """Return a value that is allowed as a ``float``; -0.0 becomes 0.0."""
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
    """Check that a value is text, not blank and not too long."""
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_TEXT:
        raise ValueError(f"a name of at most MAX_TEXT = {MAX_TEXT} characters")
    return value


def one_of(*allowed: str, joint: str = ", ", before: str = "") -> Callable[[Any], str]:
    """Return a check for words; an error lists those that are allowed."""

    def check(value: Any) -> str:
        if value not in allowed:
            raise ValueError(before + joint.join(allowed))
        return str(value)

    return check


def backend(value: Any) -> str:
    """Check that a value names an installed backend."""
    return one_of(*backends.backend_names(), before="one of ")(value)


def due_times(value: Any) -> str:
    """Check that a value is the fewest and the most steps until an order is due."""
    times = re.fullmatch(r"(0|[1-9]\d{0,8}):(0|[1-9]\d{0,8})", str(value))
    if times is None or int(times[1]) > int(times[2]):
        raise ValueError('"FEWEST:MOST" steps, such as "50:150"')
    return times[0]


def size(value: Any) -> str:
    """Check that a value is a height and a width such as ``7x12``."""
    sides = re.fullmatch(r"([1-9]\d{0,3})x([1-9]\d{0,3})", str(value))
    if sides is None or min(map(int, sides.groups())) < 4:
        raise ValueError('a size "HEIGHTxWIDTH" of at least 4x4, such as "7x12"')
    return sides[0]


PARAMETERS = {
    FLEET: Parameter(
        8, Whole(1, MAX_BODIES), "{}, makes it a fleet with orders",
        question="How many robots are too many?", of_fleets=True, help="Number of robots.",
    ),
    PLANNER: Parameter(
        NO_PLANNER, text, "none, or as in 'warehouse fleet', of fleets",
        question="Which planner does best?", of_fleets=True,
    ),
    "assignment": Parameter(
        DEFAULT_ASSIGNMENT, one_of(*ASSIGNMENTS, before="one of "),
        ", ".join(ASSIGNMENTS),
        question="How should orders be assigned?", of_fleets=True, is_planned=True,
        help=f"Which robot of a planner goes for which order: {', '.join(ASSIGNMENTS)}. "
        f"Default: {DEFAULT_ASSIGNMENT}.",
    ),
    "agent": Parameter(
        "greedy", text, "a name as in 'warehouse run'",
        question="Which agent does best?", is_planned=False,
    ),
    "escape": Parameter(
        True, flag, "on or off, of agent greedy", {"agent": "greedy"},
        "Does escaping loops cut delivery time, or does it make the robot wander?",
    ),
    "memory": Parameter(
        10, Whole(0), "{}, of agent greedy", {"agent": "greedy", "escape": True},
        "How much should an agent remember to notice a loop?",
        help="Positions that the greedy agent remembers. Default: 10.",
    ),
    "layout": Parameter(
        DEFAULT, text, "a file, a name, or random", question="Which layout is hardest?"
    ),
    "size": Parameter(
        "7x12", size, "HEIGHTxWIDTH, of layout random", {"layout": RANDOM},
        "What does a larger grid do?",
    ),
    "density": Parameter(
        0.2, Number(0, MAX_DENSITY), "{}, of layout random", {"layout": RANDOM},
        "What do more obstacles do?",
    ),
    "stations": Parameter(  # for a layout file its default is another, see case.py
        str(Stations.DRAWN), one_of(*Stations, joint=" or "),
        "drawn or kept, of lone robots",
        question="What do random pickups and dropoffs change?", of_fleets=False,
    ),
    "order_rate": Parameter(
        0.06, Number(0, MAX_VALUE), "orders that arrive in a step, of fleets",
        question="How many orders can the fleet carry out?", of_fleets=True,
        help="Orders that arrive in a step on average.",
    ),
    "due": Parameter(
        "50:150", due_times, "FEWEST:MOST steps, of fleets",
        question="What do earlier due times change?", of_fleets=True,
        help="Steps from release to due time of an order.",
    ),
    "chargers": Parameter(  # by default as many as the layout has, see case.py
        0, Whole(0), "at most those of the layout, of fleets",
        question="How many chargers does the fleet need?", of_fleets=True,
    ),
    "people": Parameter(
        0, Whole(0, MAX_BODIES), "{}, of fleets",
        question="What do people on the floor change?", of_fleets=True,
        help="People who walk on the floor.",
    ),
    "battery": Parameter(
        200, Whole(1), question="How does battery capacity affect success?",
        help="Steps that a full battery lasts.",
    ),
    "max_steps": Parameter(
        200, Whole(1), question="How long should an episode be?",
        help="Maximum steps of an episode.",
    ),
    "view_radius": Parameter(
        2, Whole(0, MAX_VIEW_RADIUS), question="What does it help to see further?",
        help=f"Cells seen in each direction, up to {MAX_VIEW_RADIUS}.",
    ),
    "backend": Parameter(
        "grid", backend, "grid, physics, of fleets driving",
        question="What does the real robot do with the same policy?",
    ),
}  # fmt: skip

PHYSICAL = {"robot": "RobotSpec", "disturbances": "Disturbances"}
"""Groups of parameters of the physics backend, and the class that has them as fields."""


def usual(name: str) -> Any:
    """Return the default of a parameter."""
    return PARAMETERS[name].default


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
            return Parameter(allowed[field], Number(), needs={"backend": "physics"})
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
    """Return a value of a parameter as it is stored, by its own check or by another one.

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
