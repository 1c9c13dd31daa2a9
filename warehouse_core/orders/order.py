"""Orders, and the streams that they are drawn from.

An *order* is one item to be brought from a pickup to a dropoff. Times are in steps; in a step that
takes its nominal second a rate of 0.1 orders a step is 360 an hour.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from warehouse_core.arguments import MAX_STEPS, as_cell, real_number, settle, whole_number
from warehouse_core.wording import brief
from warehouse_core.world.tables import Integers
from warehouse_core.world.tiles import Cell

MAX_ORDERS = 1_000_000
"""Limit on the orders of an episode."""

OPEN = -1
"""The robot of an order that any robot may take."""


class Order(NamedTuple):
    """One item to be brought from a pickup to a dropoff, and what has become of it.

    Attributes:
        released: step at which it appears.
        due: step by which it must be delivered to be on time, at least ``released``.
        pickup: open cell where the item waits.
        dropoff: another open cell, where it is due.
        robot: the only robot that may take it; ``None`` leaves the order open to all.
        taken_by: the robot that has taken it, or ``None``.
        taken: step at which it was taken, or ``None``.
        delivered: step at which it was delivered, or ``None``.

    Example:
        >>> from warehouse_core import Order
        >>> order = Order(released=0, due=50, pickup=(1, 3), dropoff=(5, 6))
        >>> order.due, order.delivered
        (50, None)
    """

    released: int
    due: int
    pickup: Cell
    dropoff: Cell
    robot: int | None = None
    taken_by: int | None = None
    taken: int | None = None
    delivered: int | None = None


@dataclass(frozen=True)
class OrderStream:
    """A Poisson process of orders between the pickups and dropoffs of a layout.

    Several streams follow one another in time: each lasts until the next one starts.

    Args:
        rate: mean number of orders released in a step, finite and at least 0.
        due: fewest and most steps from release to due time, drawn uniformly.
        pickup_weights: weight of each pickup of the layout in the draws, in row-major order;
            ``None`` draws all equally often.
        dropoff_weights: the same for the dropoffs.
        start: first step of this stream.

    Raises:
        ValueError: a value that is not allowed.
        TypeError: a value of another type.

    Example:
        >>> from warehouse_core import FleetEnv, OrderStream
        >>> quiet, busy = OrderStream(rate=0.02), OrderStream(rate=0.2, start=100)
        >>> env = FleetEnv(robots=2, orders=[quiet, busy])
    """

    rate: float = 0.1
    due: tuple[int, int] = (50, 150)
    pickup_weights: tuple[float, ...] | None = None
    dropoff_weights: tuple[float, ...] | None = None
    start: int = 0

    def __post_init__(self) -> None:
        start = whole_number("start", self.start, 0, MAX_STEPS)
        settle(self, rate=real_number("rate", self.rate), start=start)
        _settle_draws(self)


@dataclass(frozen=True)
class OrderQueue:
    """A constant number of orders: when one is delivered, another is released.

    Args:
        size: number of orders that are released and not delivered, 1 to ``MAX_ORDERS``.
        due: fewest and most steps from release to due time, drawn uniformly.
        pickup_weights: the same as in ``OrderStream``.
        dropoff_weights: the same for the dropoffs.

    Raises:
        ValueError: a value that is not allowed.
        TypeError: a value of another type.

    Example:
        >>> from warehouse_core import FleetEnv, OrderQueue, shelf_layout
        >>> env = FleetEnv(shelf_layout(pickups=4), robots=2, orders=OrderQueue(3), seed=1)
        >>> observations, info = env.reset()
        >>> len(env.orders)
        3
    """

    size: int
    due: tuple[int, int] = (50, 150)
    pickup_weights: tuple[float, ...] | None = None
    dropoff_weights: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        settle(self, size=whole_number("size", self.size, 1, MAX_ORDERS))
        _settle_draws(self)


Orders = float | OrderStream | OrderQueue | Sequence[OrderStream] | Sequence[Order]
"""Forms in which a fleet accepts its orders; a number is the rate of an ``OrderStream``."""


class OrderArrays(NamedTuple):
    """``K`` orders as ``[K]`` intp arrays, in order of release; cells are ``row * W + col``."""

    released: Integers
    due: Integers
    pickup: Integers
    dropoff: Integers
    robot: Integers


def _settle_draws(orders: OrderStream | OrderQueue) -> None:
    """Check due times and weights, and put them in their plain form."""
    fewest, most = as_cell("due", orders.due, "(fewest, most)")
    if not 0 <= fewest <= most <= MAX_STEPS:
        raise ValueError(
            f"due is {brief(orders.due)}; it must be fewest and most steps after the release, "
            f"0 <= fewest <= most <= {MAX_STEPS}"
        )
    settle(
        orders,
        due=(fewest, most),
        pickup_weights=_weights("pickup_weights", orders.pickup_weights),
        dropoff_weights=_weights("dropoff_weights", orders.dropoff_weights),
    )


def _weights(name: str, weights: Sequence[float] | None) -> tuple[float, ...] | None:
    if weights is None:
        return None
    if not isinstance(weights, (tuple, list)):
        raise TypeError(f"{name} is {brief(weights)}; it must be a tuple of numbers")
    shares = tuple(real_number(f"{name}[{place}]", each) for place, each in enumerate(weights))
    if not 0 < sum(shares) < math.inf:
        raise ValueError(f"{name} is {brief(weights)}; their sum must be above 0 and finite")
    return shares
