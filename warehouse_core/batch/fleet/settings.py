"""The settings of a fleet, checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from itertools import islice
from typing import Any

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
from warehouse_core.batch.fleet.battery import Battery
from warehouse_core.batch.fleet.people import MAX_BODIES, People
from warehouse_core.orders.order import Order, OrderQueue, OrderStream
from warehouse_core.wording import brief
from warehouse_core.world.moves import ACTION_SETS, COMPASS, MOVES, TURN, ActionSet
from warehouse_core.world.tiles import Cell


@dataclass(frozen=True)
class FleetSettings:
    """The arguments of ``FleetEnv`` that are neither its layout nor its backend; see there.

    Raises:
        ValueError: a value that is not allowed.
        TypeError: a value of another type.
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
        """Return settings given as ``FleetEnv`` takes them, with its defaults."""
        read = {name: form(settings[name]) for name, form in _FORMS.items() if name in settings}
        return cls(robots, **settings | read)

    def to_json(self) -> dict[str, Any]:
        """Return the settings as values that JSON can hold."""
        values = asdict(self)
        # Files are as they were before there was a knee, and before there were other moves.
        if self.battery.knee == 1:
            del values["battery"]["knee"]
        if self.moves == COMPASS:
            del values["moves"]
        return values

    @classmethod
    def from_json(cls, values: Any) -> FleetSettings:
        """Return the settings in a JSON object that ``to_json`` made.

        Raises:
            ValueError: a key is missing or unknown, or a value is of the wrong type or size.
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
            raise ValueError(f"these are no settings of a fleet: {error}") from error

    @property
    def has_orders(self) -> bool:
        """Whether robots bring items of orders, and not one each from station to station."""
        return self.orders is not None

    @property
    def is_lone(self) -> bool:
        """Whether one robot has the task of ``WarehouseEnv``, and observes what it does there."""
        return self.robots == 1 and not self.has_orders

    @property
    def has_headings(self) -> bool:
        """Whether robots drive forward and turn on the spot."""
        return self.moves == TURN

    @property
    def actions(self) -> ActionSet:
        """The actions of each robot."""
        return ACTION_SETS[self.moves]

    @property
    def bodies(self) -> int:
        """Sum of robots and people on a floor."""
        return self.robots + self.people.count


def as_orders(orders: object) -> tuple[OrderStream, ...] | tuple[Order, ...] | OrderQueue | None:
    """Return orders given as a rate, a stream, a queue, or a sequence of streams or of orders."""
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
"""Settings that ``FleetEnv`` takes in several forms, and what makes one form of them."""


def _cells(starts: Any) -> tuple[Any, ...]:
    """Return the cells of some starts, which are checked where they are taken."""
    try:
        return tuple(islice(starts, MAX_BODIES + 1))
    except Exception:  # a user's ``__iter__`` may raise anything
        raise TypeError(f"starts is {brief(starts)}; it must be a cell for each robot") from None


def _orders(values: Any) -> Any:
    """Return what ``as_orders`` takes, given as ``asdict`` or JSON returns it."""
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
