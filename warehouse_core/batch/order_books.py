"""The order books of ``B`` fleets, and the stations that their orders make of cells."""

from __future__ import annotations

from functools import partial

import numpy as np

from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.batch.floor import NO_CELL, FleetFloor
from warehouse_core.orders.book import NEVER, NONE, OrderBook
from warehouse_core.orders.order import Order, OrderQueue, OrderStream
from warehouse_core.orders.sources import DrawnOrders, ListedOrders, QueuedOrders
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers, LayoutSet


class OrderBooks:
    """An ``OrderBook`` for each of ``B`` floors, and what it means to their ``N`` robots.

    A cell is a pickup to a robot where an order waits for it, and a dropoff where its order is due.

    Attributes:
        books: ``B`` books of the present episodes.
        due: ``[N]`` int32, the step by which the robot's order is due, or ``NONE``.
        all_delivered: ``[B]`` bool, whether all orders of a list are delivered; a stream has no
            end.
        rest_is_lost: ``[B]`` bool, whether all orders of a list are delivered but for those that
            are lost, one or more.
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
        """Draw the orders of a new episode on a floor."""
        for cell in self.books[floor].waiting_at:
            self._floor.set_waiting(floor, cell, False)
        book = self.books[floor] = self._new_book(floor, stream)
        book.changed[0].update(range(self._robots))
        self._update(floor)

    def release(self, steps: Integers, cells: Integers, out: Integers) -> None:
        """Let orders appear and, if it is so set, assign open orders to robots without one.

        ``steps`` are ``[B]``, the ``cells`` of the robots ``[N]``, and ``out`` the rows of those
        that cannot drive any more.
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
        """Give a robot the order that waits for it where it is; return whether there was one.

        After this and ``deliver`` the stations are those from before until ``release``.
        """
        floor, robot = divmod(row, self._robots)
        self._touched.add(floor)
        return self.books[floor].take(robot, cell, step)

    def deliver(self, row: int, step: int) -> int:
        """Book the delivery of what a robot carries; return by how many steps it is late."""
        floor, robot = divmod(row, self._robots)
        book = self.books[floor]
        order = book.deliver(robot, step)
        self._touched.add(floor)
        return max(step - int(book.orders.due[order]), 0)

    def assign(self, floor: int, robot: int, order: int | None) -> None:
        """Let an order wait for one robot only; see ``OrderBook.assign``."""
        self.books[floor].assign(robot, order)
        self._update(floor)

    def strand(self, rows: Integers) -> None:
        """Give back the orders of robots that cannot drive any more, until ``release``."""
        for row in rows.tolist():
            floor, robot = divmod(row, self._robots)
            book = self.books[floor]
            order = int(book.order_of[robot])
            if order != NONE and book.taken[order] == NONE:
                book.assign(robot, None)
                self._touched.add(floor)

    def lose(self, rows: Integers, cells: Integers) -> list[int]:
        """Let orders be lost, see ``OrderBook.lose``; return rows of robots that carried one.

        ``rows`` are of robots that cannot drive any more, and ``cells`` where they are.
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
        """Bring stations and arrays up to date with what has changed in a book."""
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
        """Bring due times and stations of some robots up to date."""
        orders, rows = book.order_of[robots], floor * self._robots + robots
        has_order = orders != NONE
        held, known = orders[has_order], book.orders
        pickups = np.where(book.taken[held] == NONE, known.pickup[held], NO_CELL)
        tasks = np.full((3, len(robots)), NO_CELL)
        tasks[:, has_order] = known.due[held], pickups, known.dropoff[held]
        self.due[rows] = np.where(has_order, tasks[0], NONE)
        self._floor.put_stations(rows, tasks[1], tasks[2])
        self._is_idle[floor, robots] = ~has_order


def _source(layout: Layout, settings: FleetSettings) -> ListedOrders | DrawnOrders | QueuedOrders:
    orders = settings.orders
    if isinstance(orders, OrderQueue):
        return QueuedOrders(orders, layout)
    streams = [order for order in orders or () if isinstance(order, OrderStream)]
    if streams:
        return DrawnOrders(streams, layout, settings.max_steps)
    listed = [order for order in orders or () if isinstance(order, Order)]
    return ListedOrders(listed, layout, settings.robots)
