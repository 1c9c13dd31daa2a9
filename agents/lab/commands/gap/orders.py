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

    Args:
        layout: layout with the stations, each of which is drawn equally often.
        rate: mean number of orders released in a second, above 0.
        count: number of orders.
        due: fewest and most seconds from release to due time, drawn uniformly.
        seed: seed of all that is drawn.

    Raises:
        LayoutError: the layout has no pickup or no dropoff.
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
    found = []
    for order in orders:
        released = math.ceil(order.released / seconds)
        due = max(math.floor(order.due / seconds), released)
        found.append(Order(released, due, order.pickup, order.dropoff))
    return found
