"""Orders with times in seconds, the same for motions whose steps last differently long."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warehouse_core import Cell, Layout, LayoutError, Order


class TimedOrder(NamedTuple):
    """An item to be brought from a pickup to a dropoff; times are seconds from the reset."""

    released: float
    due: float
    pickup: Cell
    dropoff: Cell


def draw_orders(
    layout: Layout, rate: float, count: int, due: tuple[int, int], seed: int
) -> list[TimedOrder]:
    """Return the first orders of a Poisson process, in order of release.

    Stations are drawn equally often, and so are times between the fewest and the most seconds from
    release to due time. In a second ``rate`` orders are released on average.
    """
    for kind, places in (("pickup", layout.pickups), ("dropoff", layout.dropoffs)):
        if not places:
            raise LayoutError(f"the layout has no {kind}; orders are drawn from its stations")
    stream = np.random.default_rng(seed)
    released = stream.exponential(1 / rate, count).cumsum()
    dues = released + stream.uniform(*due, count)
    pickups, dropoffs = (
        stream.integers(len(places), size=count).tolist()
        for places in (layout.pickups, layout.dropoffs)
    )
    return [
        TimedOrder(start, end, layout.pickups[pickup], layout.dropoffs[dropoff])
        for start, end, pickup, dropoff in zip(
            released.tolist(), dues.tolist(), pickups, dropoffs, strict=True
        )
    ]


def in_steps(orders: Sequence[TimedOrder], seconds: float) -> list[Order]:
    """Return orders for a fleet whose steps last so many seconds.

    None is released too early, and none is due too late, unless it is due before it is released.
    """
    releases = [math.ceil(order.released / seconds) for order in orders]
    return [
        Order(released, max(math.floor(order.due / seconds), released), *order[2:])
        for released, order in zip(releases, orders, strict=True)
    ]
