"""The order books of ``B`` fleets, and the stations that result from their orders."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np

from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.batch.floor import NO_CELL, FleetFloor
from warehouse_core.orders.book import NEVER, NONE, OrderBook
from warehouse_core.orders.order import Order, OrderQueue, OrderStream
from warehouse_core.orders.sources import ListedOrders, QueuedOrders, RandomOrders
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers, LayoutSet


class OrderBooks:
    """An ``OrderBook`` for each of ``B`` floors, and the stations of their ``N`` robots.

    A cell is a pickup for a robot if an order for it waits there, and a dropoff if its order is to
    be delivered there.

    The orders of streams appear on all floors at once. The book of a floor releases them only when
    it is needed, because most steps need none.

    Attributes:
        due: ``[N]`` int32, step by which the robot's order is due, or ``NONE``.
        all_delivered: ``[B]`` flags of floors where all orders of a list are delivered. Streams and
            queues have no end.
        rest_is_lost: ``[B]`` flags of floors where at least one order of a list is lost and all
            others are delivered.
        has_ended: ``True`` if any of these flags is set.
    """

    def __init__(self, layouts: LayoutSet, settings: FleetSettings, floor: FleetFloor) -> None:
        floors, self._robots = len(layouts.kind), settings.robots
        self._layouts, self._floor, self._dispatches = layouts, floor, settings.dispatch
        self._sources = [_source(kind, settings) for kind in layouts.kinds]
        self._can_end = self._sources[0].ends
        streams = [np.random.default_rng(0)] * floors
        self._books = [self._new_book(*each) for each in enumerate(streams)]
        self._next_release = np.full(floors, NEVER)
        # The steps and pickups of the orders of each floor, and how many of them have appeared.
        self._is_lazy = floors > 1 and isinstance(self._sources[0], RandomOrders)
        self._releases, self._pickups = np.full((2, floors, 1), NEVER)
        self._appeared = np.zeros(floors, np.intp)
        self._behind = [NONE] * floors
        self.due = np.full(floors * settings.robots, NONE, np.int32)
        self._is_idle = np.ones((floors, settings.robots), np.bool_)
        self.has_ended = False
        self._has_open, self.all_delivered, self.rest_is_lost = np.zeros((3, floors), np.bool_)
        self._touched: set[int] = set()

    def begin(self, floor: int, stream: np.random.Generator) -> None:
        """Start an episode on a floor with new orders."""
        self._floor.set_waiting(floor, self._books[floor].orders.pickup, False)
        book = self._books[floor] = self._new_book(floor, stream)
        rows = np.arange(floor * self._robots, (floor + 1) * self._robots)
        self._set_tasks(rows, np.full((len(rows), 3), NO_CELL))
        self._appeared[floor], self._behind[floor] = 0, NONE
        if self._is_lazy:
            self._schedule(floor, book)
        self._update([floor])

    def book(self, floor: int) -> OrderBook:
        """Return the book of a floor, with all orders that have appeared."""
        book, step = self._books[floor], self._behind[floor]
        if step != NONE:
            self._behind[floor] = NONE
            book.release(step)
        return book

    def release(self, steps: Integers, cells: Integers, out: Integers) -> None:
        """Release orders and, with ``dispatch``, assign open orders to robots without one.

        Args:
            steps: ``[B]`` steps taken on each floor.
            cells: ``[N]`` cells of the robots.
            out: rows of robots that can no longer drive.
        """
        if self._touched:
            self._update(self._touched)
            self._touched.clear()
        due = (self._next_release <= steps).nonzero()[0]
        if self._is_lazy:
            self._appear(due, steps)
        elif len(due):
            for floor in due.tolist():
                self._books[floor].release(int(steps[floor]))
            self._update(due.tolist())
        if not self._dispatches or not np.count_nonzero(self._has_open):
            return
        if not np.count_nonzero(self._is_idle):
            return
        free = self._is_idle.copy()
        free.reshape(-1)[out] = False
        floors = np.flatnonzero(free.any(axis=1) & self._has_open).tolist()
        for floor in floors:
            robots = free[floor].nonzero()[0]  # np.flatnonzero takes three times as long
            self.book(floor).dispatch(robots, cells[floor * self._robots + robots])
        self._update(floors)

    def take(self, row: int, cell: int, step: int) -> bool:
        """Let a robot pick up an item at its cell, and return whether it has done so.

        After this and after ``deliver`` the stations stay unchanged until ``release``.
        """
        floor, robot = divmod(row, self._robots)
        self._touched.add(floor)
        return self.book(floor).take(robot, cell, step)

    def deliver(self, row: int, step: int) -> int:
        """Record the delivery of a robot's item, and return the steps by which it is late."""
        floor, robot = divmod(row, self._robots)
        book = self.book(floor)
        order = book.deliver(robot, step)
        self._touched.add(floor)
        return max(step - int(book.orders.due[order]), 0)

    def assign(self, floor: int, robot: int, order: int | None) -> None:
        """Assign an order to a robot; see ``OrderBook.assign``."""
        self.book(floor).assign(robot, order)
        self._update([floor])

    def strand(self, rows: Integers) -> None:
        """Give back the orders of robots that can no longer drive and carry no item."""
        for row in rows.tolist():
            floor, robot = divmod(row, self._robots)
            book = self.book(floor)
            order = int(book.order_of[robot])
            if order != NONE and book.taken[order] == NONE:
                book.assign(robot, None)
                self._touched.add(floor)

    def lose(self, rows: Integers, cells: Integers) -> list[int]:
        """Give up the orders that robots hold or block; see ``OrderBook.lose``.

        Args:
            rows: rows of robots that can no longer drive.
            cells: cells of these robots.

        Returns:
            Rows of the other robots, which have lost the items that they carried.
        """
        freed, floors = list[int](), rows // self._robots
        each = np.unique(floors).tolist()
        for floor in each:
            first, book = floor * self._robots, self.book(floor)
            robots = book.lose(rows[floors == floor] - first, cells[floors == floor])
            freed += [first + robot for robot in robots]
        self._update(each)
        return freed

    def _new_book(self, floor: int, stream: np.random.Generator) -> OrderBook:
        kind = self._layouts.kind[floor]
        source = self._sources[kind]
        more = partial(source.draw, stream) if isinstance(source, QueuedOrders) else None
        orders = source.draw(stream)
        return OrderBook(orders, self._robots, self._layouts.kinds[kind], more)

    def _schedule(self, floor: int, book: OrderBook) -> None:
        """Store the steps and pickups of a floor's orders."""
        count, width = len(book.orders.released), self._releases.shape[1]
        if count >= width:
            room = ((0, 0), (0, count + 1 - width))
            self._releases = np.pad(self._releases, room, constant_values=NEVER)
            self._pickups = np.pad(self._pickups, room)
        self._releases[floor] = NEVER
        self._releases[floor, :count] = book.orders.released
        self._pickups[floor, :count] = book.orders.pickup

    def _appear(self, floors: Integers, steps: Integers) -> None:
        """Show the orders that are to be released on some floors, and note it for their books."""
        for floor, step in zip(floors.tolist(), steps[floors].tolist(), strict=True):
            self._behind[floor] = step
        self._has_open[floors] = True
        while len(floors):
            numbers = self._appeared[floors]
            self._floor.set_waiting(floors, self._pickups[floors, numbers], True)
            self._appeared[floors] = numbers + 1
            self._next_release[floors] = following = self._releases[floors, numbers + 1]
            floors = floors[following <= steps[floors]]

    def _update(self, floors: Iterable[int]) -> None:
        """Update the stations and arrays after changes in the books of some floors."""
        rows, tasks, waiting = list[int](), list[tuple[int, int, int]](), list[tuple[int, ...]]()
        for floor in floors:
            book = self._books[floor]
            robots, cells = book.changed
            waiting += [(floor, cell, book.waiting_at[cell] > 0) for cell in cells]
            rows += [floor * self._robots + robot for robot in robots]
            tasks += [book.task(robot) for robot in robots]
            robots.clear()
            cells.clear()
            self._has_open[floor] = book.has_open_orders
            self._next_release[floor] = book.next_release
            if self._can_end:
                self.all_delivered[floor] = book.is_done and not book.lost
                self.rest_is_lost[floor] = book.is_done and book.lost
        if self._can_end:
            self.has_ended = bool(np.count_nonzero(self.all_delivered | self.rest_is_lost))
        if waiting:
            self._floor.set_waiting(*np.array(waiting).T)
        if rows:
            self._set_tasks(np.array(rows), np.array(tasks))

    def _set_tasks(self, rows: Integers, tasks: Integers) -> None:
        """Set the due times, pickups and dropoffs ``[N, 3]`` of some robots."""
        self.due[rows] = tasks[:, 0]
        self._floor.put_stations(rows, tasks[:, 1:].T)
        self._is_idle.reshape(-1)[rows] = tasks[:, 2] == NO_CELL


def _source(layout: Layout, settings: FleetSettings) -> ListedOrders | RandomOrders | QueuedOrders:
    orders = settings.orders
    if isinstance(orders, OrderQueue):
        return QueuedOrders(orders, layout)
    streams = [order for order in orders or () if isinstance(order, OrderStream)]
    if streams:
        return RandomOrders(streams, layout, settings.max_steps)
    listed = [order for order in orders or () if isinstance(order, Order)]
    return ListedOrders(listed, layout, settings.robots)
