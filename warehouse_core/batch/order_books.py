"""The order books of ``B`` fleets, and the stations that result from their orders."""

from __future__ import annotations

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

    Attributes:
        books: ``B`` books of the current episodes.
        due: ``[N]`` int32, step by which the robot's order is due, or ``NONE``.
        all_delivered: ``[B]`` flags of floors where all orders of a list are delivered. Streams and
            queues have no end.
        rest_is_lost: ``[B]`` flags of floors where at least one order of a list is lost and all
            others are delivered.
    """

    def __init__(self, layouts: LayoutSet, settings: FleetSettings, floor: FleetFloor) -> None:
        floors, self._robots = len(layouts.kind), settings.robots
        self._layouts, self._floor, self._dispatches = layouts, floor, settings.dispatch
        self._sources = [_source(kind, settings) for kind in layouts.kinds]
        streams = [np.random.default_rng(0)] * floors
        self.books = [self._new_book(*each) for each in enumerate(streams)]
        self._next_release = np.full(floors, NEVER)
        self.due = np.full(floors * settings.robots, NONE, np.int32)
        self._is_idle = np.ones((floors, settings.robots), np.bool_)
        self._has_open, self.all_delivered, self.rest_is_lost = np.zeros((3, floors), np.bool_)
        self._touched: set[int] = set()

    def begin(self, floor: int, stream: np.random.Generator) -> None:
        """Start an episode on a floor with new orders."""
        for cell in self.books[floor].waiting_at:
            self._floor.set_waiting(floor, cell, False)
        book = self.books[floor] = self._new_book(floor, stream)
        book.changed[0].update(range(self._robots))
        self._update(floor)

    def release(self, steps: Integers, cells: Integers, out: Integers) -> None:
        """Release orders and, with ``dispatch``, assign open orders to robots without one.

        Args:
            steps: ``[B]`` steps taken on each floor.
            cells: ``[N]`` cells of the robots.
            out: rows of robots that can no longer drive.
        """
        for floor in self._touched:
            self._update(floor)
        self._touched.clear()
        for floor in (self._next_release <= steps).nonzero()[0].tolist():
            self.books[floor].release(int(steps[floor]))
            self._update(floor)
        if not self._dispatches or not np.count_nonzero(self._has_open):
            return
        if not np.count_nonzero(self._is_idle):
            return
        free = self._is_idle.copy()
        free.reshape(-1)[out] = False
        for floor in np.flatnonzero(free.any(axis=1) & self._has_open).tolist():
            robots = np.flatnonzero(free[floor])
            self.books[floor].dispatch(robots, cells[floor * self._robots + robots])
            self._update(floor)

    def take(self, row: int, cell: int, step: int) -> bool:
        """Let a robot pick up an item at its cell, and return whether it has done so.

        After this and after ``deliver`` the stations stay unchanged until ``release``.
        """
        floor, robot = divmod(row, self._robots)
        self._touched.add(floor)
        return self.books[floor].take(robot, cell, step)

    def deliver(self, row: int, step: int) -> int:
        """Record the delivery of a robot's item, and return the steps by which it is late."""
        floor, robot = divmod(row, self._robots)
        book = self.books[floor]
        order = book.deliver(robot, step)
        self._touched.add(floor)
        return max(step - int(book.orders.due[order]), 0)

    def assign(self, floor: int, robot: int, order: int | None) -> None:
        """Assign an order to a robot; see ``OrderBook.assign``."""
        self.books[floor].assign(robot, order)
        self._update(floor)

    def strand(self, rows: Integers) -> None:
        """Give back the orders of robots that can no longer drive and carry no item."""
        for row in rows.tolist():
            floor, robot = divmod(row, self._robots)
            book = self.books[floor]
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
        for floor in np.unique(floors).tolist():
            first, book = floor * self._robots, self.books[floor]
            robots = book.lose(rows[floors == floor] - first, cells[floors == floor])
            freed += [first + robot for robot in robots]
            self._update(floor)
        return freed

    def _new_book(self, floor: int, stream: np.random.Generator) -> OrderBook:
        kind = self._layouts.kind[floor]
        source = self._sources[kind]
        more = partial(source.draw, stream) if isinstance(source, QueuedOrders) else None
        orders = source.draw(stream)
        return OrderBook(orders, self._robots, self._layouts.kinds[kind], more)

    def _update(self, floor: int) -> None:
        """Update the stations and arrays after changes in a book."""
        book = self.books[floor]
        robots, cells = book.changed
        for cell in cells:
            self._floor.set_waiting(floor, cell, book.waiting_at[cell] > 0)
        if robots:
            self._set_orders(floor, book, np.array(list(robots), np.intp))
        robots.clear()
        cells.clear()
        self._has_open[floor] = book.has_open_orders
        is_over = self._sources[self._layouts.kind[floor]].ends and book.is_done
        self.all_delivered[floor] = is_over and not book.lost
        self.rest_is_lost[floor] = is_over and book.lost
        self._next_release[floor] = book.next_release

    def _set_orders(self, floor: int, book: OrderBook, robots: Integers) -> None:
        """Update the due times and stations of some robots."""
        orders, rows = book.order_of[robots], floor * self._robots + robots
        has_order = orders != NONE
        held, known = orders[has_order], book.orders
        pickups = np.where(book.taken[held] == NONE, known.pickup[held], NO_CELL)
        tasks = np.full((3, len(robots)), NO_CELL)
        tasks[:, has_order] = known.due[held], pickups, known.dropoff[held]
        self.due[rows] = np.where(has_order, tasks[0], NONE)
        self._floor.put_stations(rows, tasks[1], tasks[2])
        self._is_idle[floor, robots] = ~has_order


def _source(layout: Layout, settings: FleetSettings) -> ListedOrders | RandomOrders | QueuedOrders:
    orders = settings.orders
    if isinstance(orders, OrderQueue):
        return QueuedOrders(orders, layout)
    streams = [order for order in orders or () if isinstance(order, OrderStream)]
    if streams:
        return RandomOrders(streams, layout, settings.max_steps)
    listed = [order for order in orders or () if isinstance(order, Order)]
    return ListedOrders(listed, layout, settings.robots)
