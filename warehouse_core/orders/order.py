"""Orders, and the random streams that produce them.

An *order* asks for one item to be moved from a pickup to a dropoff. Times are in steps. A step
nominally takes a second, so a rate of 0.1 orders per step is 360 orders per hour.
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
"""Value of ``robot`` in ``OrderArrays`` for orders that any robot may take."""


class Order(NamedTuple):
    """An order to move one item from a pickup to a dropoff, and its progress.

    Attributes:
        released: step at which the order appears.
        due: last step at which a delivery is on time; at least ``released``.
        pickup: open cell where the item waits.
        dropoff: another open cell, where the item is to be delivered.
        robot: the only robot that may take the order; ``None`` if any robot may.
        taken_by: robot that has picked up the item, or ``None``.
        taken: step at which the item was picked up, or ``None``.
        delivered: step at which the item was delivered, or ``None``.

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
    """A random stream of orders: a Poisson process between the stations of a layout.

    Several streams can follow one another. Each lasts until the next one starts.

    Args:
        rate: mean number of orders per step, finite and at least 0.
        due: fewest and most steps from release to due time; the number is uniformly distributed.
        pickup_weights: relative frequency of each pickup of the layout, in row-major order;
            ``None`` makes all equally frequent.
        dropoff_weights: relative frequency of each dropoff, likewise.
        start: first step of this stream.

    Raises:
        ValueError: a value is not allowed.
        TypeError: a value has the wrong type.

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
    """A constant number of orders in progress: each delivery releases another order.

    Args:
        size: number of released and undelivered orders, 1 to ``MAX_ORDERS``.
        due: fewest and most steps from release to due time; the number is uniformly distributed.
        pickup_weights: relative frequency of each pickup, as in ``OrderStream``.
        dropoff_weights: relative frequency of each dropoff, likewise.

    Raises:
        ValueError: a value is not allowed.
        TypeError: a value has the wrong type.

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
"""Types of orders that a fleet accepts; a number is the rate of an ``OrderStream``."""


class OrderArrays(NamedTuple):
    """``K`` orders as ``[K]`` intp arrays, in order of release; cells are ``row * W + col``."""

    released: Integers
    due: Integers
    pickup: Integers
    dropoff: Integers
    robot: Integers


def _settle_draws(orders: OrderStream | OrderQueue) -> None:
    """Check the due times and weights, and store them as plain Python values."""
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
