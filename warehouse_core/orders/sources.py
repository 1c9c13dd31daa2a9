"""Sources of the orders of an episode: a list, random streams, or a queue."""

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
    """A list of orders that is the same in every episode.

    The progress that is recorded in the orders is ignored.

    Raises:
        OrderError: an order cannot be carried out; the message gives its number, counted from 0.
    """

    ends = True

    def __init__(self, orders: Sequence[Order], layout: Layout, robots: int) -> None:
        if len(orders) > MAX_ORDERS:
            raise OrderError(f"{len(orders)} orders are more than MAX_ORDERS = {MAX_ORDERS}")
        rows = [_row(f"order {number}", each, layout, robots) for number, each in enumerate(orders)]
        rows.sort(key=itemgetter(0))
        self._arrays = OrderArrays(*np.array(rows, np.intp).T)

    def draw(self, stream: np.random.Generator) -> OrderArrays:
        """Return the orders, which are not random."""
        return self._arrays


class RandomOrders:
    """Random orders of each episode, from one or more streams in the order of their starts.

    All orders are released before the end of an episode of ``steps`` steps.

    Raises:
        LayoutError: the layout has no pickup or no dropoff.
        OrderError: the streams are out of order, their weights do not fit the layout, or the rate
            leads to more than ``MAX_ORDERS`` orders.
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
        """Return random orders for one episode."""
        # Given their number, the times of a Poisson process are independent and uniform.
        counts = stream.poisson(self._means).astype(np.intp)  # it has 32 bits in a browser
        phase = np.repeat(np.arange(len(self._means)), counts)
        released = np.sort(stream.integers(self._starts[phase], self._ends[phase]))
        due, pickup, dropoff = self._tasks.draw(phase, stream)
        return OrderArrays(released, released + due, pickup, dropoff, np.full(len(phase), OPEN))


class QueuedOrders:
    """Random orders, of which a constant number is in progress.

    Raises:
        LayoutError: the layout has no pickup or no dropoff.
        OrderError: the weights do not fit the layout.
    """

    ends = False

    def __init__(self, queue: OrderQueue, layout: Layout) -> None:
        self.size, self._tasks = queue.size, _Tasks([queue], layout)

    def draw(self, stream: np.random.Generator) -> OrderArrays:
        """Return the next ``size`` random orders, with due times as if released at step 0."""
        phase = np.zeros(self.size, np.intp)
        due, pickup, dropoff = self._tasks.draw(phase, stream)
        return OrderArrays(phase, due, pickup, dropoff, np.full(self.size, OPEN))


class _Tasks:
    """Random due times, pickups and dropoffs of the streams or the queue."""

    def __init__(self, kinds: Sequence[OrderStream | OrderQueue], layout: Layout) -> None:
        self._due = np.array([kind.due for kind in kinds])
        pickups = [kind.pickup_weights for kind in kinds]
        dropoffs = [kind.dropoff_weights for kind in kinds]
        self._pickups = _Stations("pickup", layout.pickups, pickups, layout)
        self._dropoffs = _Stations("dropoff", layout.dropoffs, dropoffs, layout)

    def draw(self, phase: Integers, stream: np.random.Generator) -> tuple[Integers, ...]:
        """Return the steps to the due time, pickups and dropoffs of random orders.

        Args:
            phase: ``[K]`` number of the stream of each order.
            stream: random numbers.
        """
        fewest, most = self._due[phase].T
        due = stream.integers(fewest, most, endpoint=True)
        pickups = self._pickups.draw(phase, stream.random(len(phase)))
        return due, pickups, self._dropoffs.draw(phase, stream.random(len(phase)))


class _Stations:
    """The pickups or the dropoffs of a layout, with their weights in each stream."""

    def __init__(
        self,
        kind: str,
        cells: Sequence[Cell],
        weights: Sequence[Sequence[float] | None],
        layout: Layout,
    ) -> None:
        if not cells:
            raise LayoutError(f"the layout has no {kind}; random orders need one")
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
        # The weights of stream i divide the interval from i to i + 1.
        sums = np.cumsum(shares, axis=1)
        sums /= sums[:, -1:]
        self._sums = (sums + np.arange(len(sums))[:, None]).ravel()

    def draw(self, phase: Integers, uniforms: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return a random cell for each stream number, given a uniform random number each."""
        place = np.searchsorted(self._sums, phase + uniforms, side="right")
        cells: NDArray[np.intp] = self._cells[place % len(self._cells)]
        return cells


def _row(name: str, order: Order, layout: Layout, robots: int) -> tuple[int, int, int, int, int]:
    """Return an order as a row of ``OrderArrays``, or raise if nobody can carry it out."""
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
    """Return the number of a cell, which must be able to be a station."""
    row, col = cell = as_cell(name, place)
    try:
        check_open(layout, cell, name)
    except LayoutError as error:
        raise OrderError(str(error)) from error
    if layout.rows[row][col] == CHARGER:
        raise OrderError(f"{name} {layout.describe(cell)}; a charger cannot be a station")
    return layout.number(cell)
