"""The checked settings of a fleet, including its batteries and people."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import (
    MAX_STEPS,
    MAX_VIEW_RADIUS,
    as_cell,
    flag,
    one_of,
    real_number,
    settle,
    whole_number,
)
from warehouse_core.motion.grid import nominal_joules
from warehouse_core.orders.order import Order, OrderQueue, OrderStream
from warehouse_core.task.rules import CHARGE
from warehouse_core.wording import brief
from warehouse_core.world.moves import ACTION_SETS, COMPASS, MOVES, TURN, ActionSet
from warehouse_core.world.tiles import Cell

STEPS, JOULES = "steps", "joules"
UNITS = (STEPS, JOULES)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Battery:
    """The battery of each robot of a fleet.

    The model has no ageing and no temperature. The capacity never changes.

    Args:
        capacity: units of a full charge, at least 1.
        unit: unit of energy. With ``"steps"`` every step costs one unit. With ``"joules"`` a step
            costs the energy of its motion.
        charge: units that a step on a charger adds at a constant current. ``None`` stands for
            ``CHARGE`` steps, or in joules for the nominal cost of as many moves.
        knee: share of a full charge at which charging changes from constant current to constant
            voltage, above 0. From there on the current falls in proportion to the missing charge.
            1 is a constant current until the battery is full. Lithium cells have about 0.8.

    Raises:
        ValueError: a value is not allowed.
        TypeError: ``capacity`` or ``charge`` is not an integer.

    Example:
        >>> from warehouse_core import Battery, FleetEnv
        >>> env = FleetEnv(robots=2, battery=Battery(20_000, "joules"))
        >>> observations, info = env.reset()
        >>> env.state_of_charge
        [1.0, 1.0]
    """

    capacity: int = 200
    unit: str = STEPS
    charge: int | None = None
    knee: float = 1.0

    def __post_init__(self) -> None:
        settle(self, capacity=whole_number("battery", self.capacity, 1, MAX_STEPS))
        one_of("unit", self.unit, UNITS)
        if self.charge is not None:
            settle(self, charge=whole_number("charge", self.charge, 1, MAX_STEPS))
        settle(self, knee=real_number("knee", self.knee, 0.0, 1.0, above=True))

    def step_cost(self, cell_size: float) -> float:
        """Return the nominal cost of a move in units."""
        return 1.0 if self.unit == STEPS else nominal_joules(cell_size, moving=True)

    def step_charge(self, cell_size: float) -> float:
        """Return the units that a step on a charger adds at a constant current."""
        return CHARGE * self.step_cost(cell_size) if self.charge is None else self.charge

    @property
    def tail(self) -> float:
        """Units at the end of a full charge that are charged at a constant voltage."""
        return (1 - self.knee) * self.capacity

    def supplied(self, missing: Floats, charge: float) -> Floats:
        """Return the units that a step of charging adds.

        Args:
            missing: ``[N]`` units missing from a full charge.
            charge: units that a step adds at a constant current.
        """
        steady: Floats = np.minimum(missing - np.minimum(missing, self.tail), charge)
        if not self.tail:
            return steady
        rest = 1 - steady / charge  # share of the step with constant voltage
        falling: Floats = np.minimum(missing, self.tail) * -np.expm1(-rest * charge / self.tail)
        return steady + falling


STATIONS, AISLES = "stations", "aisles"
HABITS = (STATIONS, AISLES)

MAX_BODIES = 100_000
"""Limit on the sum of robots and people on a floor."""


@dataclass(frozen=True)
class People:
    """The number of people on a floor, and how they walk.

    Args:
        count: number of people on each floor, 0 to ``MAX_BODIES``.
        habit: route of people. With ``"stations"`` they walk from station to station along
            shortest paths. With ``"aisles"`` they mostly walk straight on, and turn at random.
        pause: probability that a person stands still in a step, 0 to 1.

    Raises:
        ValueError: a value is not allowed.
        TypeError: ``count`` is not an integer.

    Example:
        >>> from warehouse_core import FleetEnv, People
        >>> env = FleetEnv(robots=2, people=People(3, habit="aisles"), seed=1)
        >>> observations, info = env.reset()
        >>> len(env.people)
        3
    """

    count: int
    habit: str = STATIONS
    pause: float = 0.2

    def __post_init__(self) -> None:
        count = whole_number("people", self.count, 0, MAX_BODIES)
        settle(self, count=count, pause=real_number("pause", self.pause, 0, 1))
        one_of("habit", self.habit, HABITS)


@dataclass(frozen=True)
class FleetSettings:
    """The arguments of ``FleetEnv``, except its layout, backend and seed.

    Raises:
        ValueError: a value is not allowed.
        TypeError: a value has the wrong type.
    """

    robots: int
    orders: tuple[OrderStream, ...] | tuple[Order, ...] | OrderQueue | None = None
    starts: tuple[Cell, ...] | None = None
    max_steps: int = 200
    battery: Battery = field(default_factory=Battery)
    view_radius: int = 2
    people: People = field(default_factory=lambda: People(0))
    dispatch: bool = True
    late_penalty: float = 0.0
    team_reward: bool = False
    moves: str = COMPASS

    def __post_init__(self) -> None:
        settle(
            self,
            robots=whole_number("robots", self.robots, 1, MAX_BODIES),
            max_steps=whole_number("max_steps", self.max_steps, 1, MAX_STEPS),
            view_radius=whole_number("view_radius", self.view_radius, 0, MAX_VIEW_RADIUS),
            dispatch=flag("dispatch", self.dispatch),
            late_penalty=real_number("late_penalty", self.late_penalty),
            team_reward=flag("team_reward", self.team_reward),
            moves=one_of("moves", self.moves, MOVES),
        )
        whole_number("robots and people", self.bodies, 1, MAX_BODIES)
        if self.starts is not None and len(self.starts) != self.robots:
            raise ValueError(f"{len(self.starts)} starts for {self.robots} robots; each needs one")

    @classmethod
    def of(cls, robots: int, **settings: Any) -> FleetSettings:
        """Return the settings for arguments of ``FleetEnv``, with its defaults."""
        read = {name: form(settings[name]) for name, form in _FORMS.items() if name in settings}
        return cls(robots, **settings | read)

    def to_json(self) -> dict[str, Any]:
        """Return the settings as a JSON object."""
        values = asdict(self)
        # Files without a knee or turns stay the same as before these settings existed.
        if self.battery.knee == 1:
            del values["battery"]["knee"]
        if self.moves == COMPASS:
            del values["moves"]
        return values

    @classmethod
    def from_json(cls, values: Any) -> FleetSettings:
        """Return the settings in a JSON object of ``to_json``.

        Raises:
            ValueError: a key is missing or unknown, or a value has the wrong type or size.
        """
        try:
            if {*values, "moves"} != set(names := [each.name for each in fields(cls)]):
                raise TypeError(f"their keys must be {', '.join(names)}")
            starts, orders = values["starts"], values["orders"]
            read = {
                "battery": Battery(**values["battery"]),
                "people": People(**values["people"]),
                "starts": None if starts is None else tuple(as_cell("start", c) for c in starts),
                "orders": as_orders(_orders(orders)),
            }
            return cls(**values | read)
        except (TypeError, KeyError) as error:
            raise ValueError(f"these are not settings of a fleet: {error}") from error

    @property
    def has_orders(self) -> bool:
        """Whether the fleet has orders; otherwise each robot delivers a single item."""
        return self.orders is not None

    @property
    def is_lone(self) -> bool:
        """Whether the fleet is one robot with the task and the observation of ``WarehouseEnv``."""
        return self.robots == 1 and not self.has_orders

    @property
    def has_headings(self) -> bool:
        """Whether robots have headings: they drive forward and turn on the spot."""
        return self.moves == TURN

    @property
    def actions(self) -> ActionSet:
        """The actions of each robot."""
        return ACTION_SETS[self.moves]

    @property
    def bodies(self) -> int:
        """Number of robots and people on a floor."""
        return self.robots + self.people.count


def as_orders(orders: object) -> tuple[OrderStream, ...] | tuple[Order, ...] | OrderQueue | None:
    """Return orders in one form, given in any form of ``Orders``."""
    if orders is None or isinstance(orders, OrderQueue):
        return orders
    if isinstance(orders, (int, float)) and not isinstance(orders, bool):
        return (OrderStream(orders),)
    if isinstance(orders, OrderStream):
        return (orders,)
    given = (
        tuple(orders) if isinstance(orders, (list, tuple)) and not isinstance(orders, Order) else ()
    )
    for kind in (OrderStream, Order):
        if given and all(isinstance(each, kind) for each in given):
            return given
    raise TypeError(
        f"orders are {brief(orders)}; allowed: a rate, an OrderStream, an OrderQueue, or a list of "
        "OrderStream or of Order, with at least one"
    )


_FORMS: dict[str, Callable[[Any], Any]] = {
    "orders": as_orders,
    "starts": lambda starts: None if starts is None else _cells(starts),
    "battery": lambda units: units if isinstance(units, Battery) else Battery(units),
    "people": lambda count: count if isinstance(count, People) else People(count),
}
"""Functions that convert the settings which ``FleetEnv`` accepts in several forms."""


def _cells(starts: Any) -> tuple[Any, ...]:
    """Return starts as a tuple; its cells are checked when they are used."""
    try:
        return tuple(islice(starts, MAX_BODIES + 1))
    except Exception:  # a user's ``__iter__`` may raise anything
        raise TypeError(f"starts is {brief(starts)}; it must be a cell for each robot") from None


def _orders(values: Any) -> Any:
    """Return orders in a form for ``as_orders``, given in the form of ``asdict`` or JSON."""
    if values is None:
        return None
    if isinstance(values, dict):
        return OrderQueue(**_with_tuples(values))
    return [
        OrderStream(**_with_tuples(each)) if isinstance(each, dict) else _order(*each)
        for each in values
    ]


def _with_tuples(values: dict[str, Any]) -> dict[str, Any]:
    return {name: tuple(each) if isinstance(each, list) else each for name, each in values.items()}


def _order(released: Any, due: Any, pickup: Any, dropoff: Any, *rest: Any) -> Order:
    return Order(
        whole_number("released", released),
        whole_number("due", due),
        as_cell("pickup", pickup),
        as_cell("dropoff", dropoff),
        *(None if each is None else whole_number("order", each) for each in rest),
    )
