"""Where the orders of an episode come from: a list, or streams that they are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import MAX_STEPS, as_cell, whole_number
from warehouse_core.errors import LayoutError, OrderError
from warehouse_core.orders.order import (
    MAX_ORDERS,
    OPEN,
    Order,
    OrderArrays,
    OrderQueue,
    OrderStream,
)
from warehouse_core.world.layout import Layout, check_open
from warehouse_core.world.tables import Integers
from warehouse_core.world.tiles import CHARGER, Cell


class ListedOrders:
    """Orders that are known in advance, the same in every episode.

    What has become of them is ignored.

    Raises:
        OrderError: an order that cannot be carried out, named by its number from 0.
    """

    ends = True

    def __init__(self, orders: Sequence[Order], layout: Layout, robots: int) -> None:
        if len(orders) > MAX_ORDERS:
            raise OrderError(f"{len(orders)} orders are more than MAX_ORDERS = {MAX_ORDERS}")
        rows = [_row(f"order {number}", each, layout, robots) for number, each in enumerate(orders)]
        rows.sort(key=itemgetter(0))
        self._arrays = OrderArrays(*np.array(rows, np.intp).T)

    def draw(self, stream: np.random.Generator) -> OrderArrays:
        """Return the orders; no random number is drawn."""
        return self._arrays


class DrawnOrders:
    """Orders drawn for each episode from one stream or more, in order of their starts.

    Only orders that are released before the last of the ``steps`` of an episode are drawn.

    Raises:
        LayoutError: a layout without a pickup or a dropoff.
        OrderError: streams out of order, weights that do not fit the layout, or a rate that leads
            to more than ``MAX_ORDERS``.
    """

    ends = False

    def __init__(self, streams: Sequence[OrderStream], layout: Layout, steps: int) -> None:
        starts = [stream.start for stream in streams]
        if starts != sorted(set(starts)):
            raise OrderError(f"the streams start at {starts}; each must start after the one before")
        self._starts = np.minimum(starts, steps)
        self._ends = np.array([*self._starts[1:], steps])
        lengths = (self._ends - self._starts).tolist()
        self._means = np.array(
            [each * float(stream.rate) for each, stream in zip(lengths, streams, strict=True)]
        )
        if self._means.sum() > MAX_ORDERS:
            rates = ", ".join(f"{stream.rate:.10g}" for stream in streams)
            raise OrderError(
                f"the rate {rates} leads to about {self._means.sum():.0f} orders in {steps} steps; "
                f"MAX_ORDERS = {MAX_ORDERS} are allowed"
            )
        self._tasks = _Tasks(streams, layout)

    def draw(self, stream: np.random.Generator) -> OrderArrays:
        """Return the orders of one episode."""
        # Given their number, the times of a Poisson process are independent and uniform.
        counts = stream.poisson(self._means).astype(np.intp)  # 32 bits in a browser
        phase = np.repeat(np.arange(len(self._means)), counts)
        released = np.sort(stream.integers(self._starts[phase], self._ends[phase]))
        due, pickup, dropoff = self._tasks.draw(phase, stream)
        return OrderArrays(released, released + due, pickup, dropoff, np.full(len(phase), OPEN))


class QueuedOrders:
    """Orders of which a constant number is released and not delivered.

    Raises:
        LayoutError: a layout without a pickup or a dropoff.
        OrderError: weights that do not fit the layout.
    """

    ends = False

    def __init__(self, queue: OrderQueue, layout: Layout) -> None:
        self.size, self._tasks = queue.size, _Tasks([queue], layout)

    def draw(self, stream: np.random.Generator) -> OrderArrays:
        """Return the next ``size`` orders, released at step 0; times count from the release."""
        phase = np.zeros(self.size, np.intp)
        due, pickup, dropoff = self._tasks.draw(phase, stream)
        return OrderArrays(phase, due, pickup, dropoff, np.full(self.size, OPEN))


class _Tasks:
    """Due times, pickups and dropoffs as the streams, or the queue, draw them."""

    def __init__(self, kinds: Sequence[OrderStream | OrderQueue], layout: Layout) -> None:
        self._due = np.array([kind.due for kind in kinds])
        pickups = [kind.pickup_weights for kind in kinds]
        dropoffs = [kind.dropoff_weights for kind in kinds]
        self._pickups = _Stations("pickup", layout.pickups, pickups, layout)
        self._dropoffs = _Stations("dropoff", layout.dropoffs, dropoffs, layout)

    def draw(self, phase: Integers, stream: np.random.Generator) -> tuple[Integers, ...]:
        """Return steps until they are due, pickups and dropoffs of orders of these streams."""
        fewest, most = self._due[phase].T
        due = stream.integers(fewest, most, endpoint=True)
        pickups = self._pickups.draw(phase, stream.random(len(phase)))
        return due, pickups, self._dropoffs.draw(phase, stream.random(len(phase)))


class _Stations:
    """The pickups or the dropoffs of a layout, drawn by the weights of ``streams`` streams."""

    def __init__(
        self,
        kind: str,
        cells: Sequence[Cell],
        weights: Sequence[Sequence[float] | None],
        layout: Layout,
    ) -> None:
        if not cells:
            raise LayoutError(f"the layout has no {kind}; orders are drawn from its stations")
        self._cells = layout.numbers(cells)
        for each in weights:
            if each is not None and len(each) != len(cells):
                raise OrderError(
                    f"{len(each)} {kind}_weights for the layout's {len(cells)} {kind}s; one of "
                    "each is needed"
                )
        shares = np.array(
            [np.ones(len(cells)) if each is None else each for each in weights], np.float64
        )
        # One line from 0 to the number of streams: each stream has the part from i to i + 1.
        sums = np.cumsum(shares, axis=1)
        sums /= sums[:, -1:]
        self._sums = (sums + np.arange(len(sums))[:, None]).ravel()

    def draw(self, phase: Integers, uniforms: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return a cell for each phase and uniform random number."""
        place = np.searchsorted(self._sums, phase + uniforms, side="right")
        cells: NDArray[np.intp] = self._cells[place % len(self._cells)]
        return cells


def _row(name: str, order: Order, layout: Layout, robots: int) -> tuple[int, int, int, int, int]:
    """Return an order as a row of ``OrderArrays``, or raise if it cannot be carried out."""
    pickup = _station(f"{name}: pickup", order.pickup, layout)
    dropoff = _station(f"{name}: dropoff", order.dropoff, layout)
    if pickup == dropoff:
        raise OrderError(f"{name}: pickup and dropoff are both {order.pickup}")
    released = whole_number(f"{name}: released", order.released)
    due = whole_number(f"{name}: due", order.due)
    if not 0 <= released <= due <= MAX_STEPS:
        raise OrderError(
            f"{name}: released at {released} and due at {due}; needed: "
            f"0 <= released <= due <= {MAX_STEPS}"
        )
    robot = None if order.robot is None else whole_number(f"{name}: robot", order.robot)
    if robot is not None and not 0 <= robot < robots:
        raise OrderError(f"{name}: robot {robot}; allowed: 0..{robots - 1}, or none")
    return released, due, pickup, dropoff, OPEN if robot is None else robot


def _station(name: str, place: Cell, layout: Layout) -> int:
    """Return a cell that can be a station as its number."""
    row, col = cell = as_cell(name, place)
    try:
        check_open(layout, cell, name)
    except LayoutError as error:
        raise OrderError(str(error)) from error
    if layout.rows[row][col] == CHARGER:
        raise OrderError(f"{name} {layout.describe(cell)}; a charger cannot be a station")
    return layout.number(cell)
