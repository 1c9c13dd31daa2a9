"""The orders of a fleet during an episode, with the robot that has each of them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from heapq import heapify, heappop, heappush

import numpy as np

from warehouse_core.errors import OrderError
from warehouse_core.orders.order import OPEN, Order, OrderArrays
from warehouse_core.wording import brief
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

NONE = -1
"""Value of an order, robot or step that does not exist."""

NEVER = np.iinfo(np.int64).max

AWAY = 10**8
"""Row that is farther away than all rows of any layout."""


class OrderBook:
    """``K`` orders of ``R`` robots, and their progress.

    A released order *waits* until its item is picked up. It waits for one robot or, if it is
    *open*, for the first robot that picks it. A robot has at most one order, whose item it is to
    pick up or carries.

    Args:
        orders: orders of the episode, or the first ones of a queue.
        robots: number of robots ``R``.
        layout: layout of the floor.
        more: function that returns the next orders of a queue. The queue keeps as many orders in
            progress as ``orders`` has.

    Attributes:
        order_of: ``[R]`` the order of each robot, or ``NONE``.
        lost: number of orders that will never be delivered, see ``lose``.
        taken_by, taken, delivered: ``[K]`` robots and steps, or ``NONE``.
        waiting_at: number of open orders at each cell.
        changed: robots whose order has changed, and cells whose number of open orders has changed.
            The reader clears both sets.
    """

    def __init__(
        self,
        orders: OrderArrays,
        robots: int,
        layout: Layout,
        more: Callable[[], OrderArrays] | None = None,
    ) -> None:
        self.orders, self._layout = orders, layout
        self._more, self._queue = more, len(orders.released)
        self.order_of = np.full(robots, NONE)
        self.taken_by, self.taken, self.delivered = np.full((3, len(orders.released)), NONE)
        self.waiting_at: Counter[int] = Counter()
        self.changed: tuple[set[int], set[int]] = (set(), set())
        self._released = self._deliveries = self._open = self.lost = 0
        self._is_open, self._is_lost = np.zeros((2, len(orders.released)), np.bool_)
        self._due_at: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)
        self._reserved: defaultdict[int, list[tuple[int, int]]] = defaultdict(list)

    @property
    def next_release(self) -> int:
        """The step at which the next order appears, or ``NEVER``."""
        released = self.orders.released
        if self._more and self._released - self._deliveries - self.lost >= self._queue:
            return NEVER
        return int(released[self._released]) if self._released < len(released) else NEVER

    @property
    def is_done(self) -> bool:
        """Whether every order has been delivered or lost."""
        return self._deliveries + self.lost == len(self.orders.released)

    @property
    def open_orders(self) -> list[int]:
        """The numbers of the open orders, in order of release."""
        return list(self._is_open.nonzero()[0].tolist())

    @property
    def released_orders(self) -> OrderArrays:
        """The orders that have been released."""
        return OrderArrays(*(column[: self._released] for column in self.orders))

    @property
    def has_open_orders(self) -> bool:
        """Whether there is an open order."""
        return self._open > 0

    def task(self, robot: int) -> tuple[int, int, int]:
        """Return the due time, pickup and dropoff of a robot's order, each ``NONE`` without one.

        The pickup is also ``NONE`` while the robot carries the item.
        """
        order = int(self.order_of[robot])
        if order == NONE:
            return NONE, NONE, NONE
        known, is_taken = self.orders, self.taken[order] != NONE
        pickup = NONE if is_taken else int(known.pickup[order])
        return int(known.due[order]), pickup, int(known.dropoff[order])

    def release(self, step: int) -> None:
        """Release all orders that are due for release at this step or before."""
        first = self._released
        while self.next_release <= step:
            order = self._released
            self._released += 1
            if self._more:
                self.orders.released[order] += step
                self.orders.due[order] += step
                if self._released == len(self.orders.released):
                    self._grow(self._more())
            self._offer(order)
        for robot in set(self.orders.robot[first : self._released].tolist()) - {OPEN}:
            self._take_reserved(robot)

    def take(self, robot: int, cell: int, step: int) -> bool:
        """Let a robot pick up an item at ``cell``, and return whether it has done so.

        It picks the item of its own order if that waits here, otherwise the item of the open order
        here that is due first. In the second case it gives its own order back.
        """
        order = int(self.order_of[robot])
        if order == NONE or self.orders.pickup[order] != cell:
            first = self._due_first(cell)
            if first == NONE:
                return False
            if order != NONE:
                self._offer(order)
            self._withdraw(first)
            self._give(robot, first)
            order = first
        self.taken_by[order], self.taken[order] = robot, step
        self.changed[0].add(robot)
        return True

    def deliver(self, robot: int, step: int) -> int:
        """Record the delivery of the item that a robot carries, and return its order."""
        order = int(self.order_of[robot])
        self.delivered[order] = step
        self._deliveries += 1
        self._give(robot, NONE)
        self._take_reserved(robot)
        return order

    def assign(self, robot: int, order: int | None) -> None:
        """Assign an order to a robot, and give back the order that the robot had.

        With ``None`` it only gives its order back. A robot without an order then gets the first due
        of the orders that only it may take.

        Raises:
            OrderError: the robot carries an item, or the order does not wait, or it waits for
                another robot.
        """
        had = int(self.order_of[robot])
        if had != NONE and self.taken[had] != NONE:
            raise OrderError(f"robot {robot} carries order {had}; it must deliver it first")
        if order == (None if had == NONE else had):
            return
        if order is not None:
            if not self._waits_for(robot, order):
                raise OrderError(
                    f"order {brief(order)} cannot be assigned to robot {robot}: "
                    f"{self._state(order)}"
                )
            self._withdraw(order)
        self._give(robot, NONE if order is None else order)
        if had != NONE:
            self._offer(had)
        self._take_reserved(robot)

    def lose(self, robots: Integers, cells: Integers) -> list[int]:
        """Give up the orders that robots which can no longer drive hold or block.

        An order is lost if one of the ``robots`` carries its item or is the only one that may take
        it. It is also lost if one of the ``cells`` is its dropoff, or the pickup where its item
        still waits. Other robots that had a lost order get their next one.

        Args:
            robots: robots that can no longer drive.
            cells: cells that they block.

        Returns:
            The other robots, which have lost the items that they carried.
        """
        known, freed = self.released_orders, list[int]()
        is_taken = self.taken[: self._released] != NONE
        theirs = np.where(is_taken, self.taken_by[: self._released], known.robot)
        is_lost = np.isin(theirs, robots) | np.isin(known.dropoff, cells)
        is_lost |= ~is_taken & np.isin(known.pickup, cells)
        is_lost &= (self.delivered[: self._released] == NONE) & ~self._is_lost[: self._released]
        for order in np.flatnonzero(is_lost).tolist():
            self._is_lost[order] = True
            self.lost += 1
            holders = np.flatnonzero(self.order_of == order).tolist()
            if not holders:
                self._withdraw(order)
            for robot in holders:
                is_out = robot in robots
                if not (is_out and is_taken[order]):
                    self._give(robot, NONE)
                if not is_out:
                    freed += [robot] if is_taken[order] else []
                    self._take_reserved(robot)
        return freed

    def dispatch(self, robots: Integers, cells: Integers) -> None:
        """Assign the oldest open orders, each to the nearest of these robots without an order."""
        rows, cols = np.divmod(cells, self._layout.width)
        for order in self.open_orders[: len(robots)]:
            row, col = self._layout.cell(int(self.orders.pickup[order]))
            nearest = int((abs(rows - row) + abs(cols - col)).argmin())
            rows[nearest] = AWAY
            self._withdraw(order)
            self._give(int(robots[nearest]), order)

    def records(self) -> list[Order]:
        """Return the released orders with their progress, in order of release."""
        return [self._record(order) for order in range(self._released)]

    def _record(self, order: int) -> Order:
        columns = *self.orders, self.taken_by, self.taken, self.delivered
        released, due, pickup, dropoff, *rest = (int(column[order]) for column in columns)
        robot, taken_by, taken, delivered = (None if each == NONE else each for each in rest)
        ends = self._layout.cell(pickup), self._layout.cell(dropoff)
        return Order(released, due, *ends, robot, taken_by, taken, delivered)

    def _grow(self, orders: OrderArrays) -> None:
        """Add orders that have not been released yet."""
        pairs = zip(self.orders, orders, strict=True)
        self.orders = OrderArrays(*(np.concatenate(pair) for pair in pairs))
        unknown = np.full(len(orders.released), NONE)
        self.taken_by, self.taken, self.delivered = (
            np.concatenate([each, unknown]) for each in (self.taken_by, self.taken, self.delivered)
        )
        self._is_open, self._is_lost = (
            np.concatenate([each, unknown != NONE]) for each in (self._is_open, self._is_lost)
        )

    def _offer(self, order: int) -> None:
        """Let an order wait for all robots, or for the only one that may take it."""
        robot, due = int(self.orders.robot[order]), int(self.orders.due[order])
        cell = int(self.orders.pickup[order])
        if robot == OPEN:
            self._is_open[order] = True
            self._open += 1
            heappush(self._due_at[cell], (due, order))
            self._count(cell, 1)
        else:
            heappush(self._reserved[robot], (due, order))

    def _take_reserved(self, robot: int) -> None:
        """Give a robot without an order the first due of those that only it may take."""
        if self.order_of[robot] == NONE and self._reserved[robot]:
            self._give(robot, heappop(self._reserved[robot])[1])

    def _due_first(self, cell: int) -> int:
        """Return the open order at a cell that is due first, or ``NONE``."""
        # The heap still has orders that have been taken since they were pushed.
        waiting = self._due_at[cell]
        while waiting and not self._is_open[waiting[0][1]]:
            heappop(waiting)
        return waiting[0][1] if waiting else NONE

    def _waits_for(self, robot: int, order: int) -> bool:
        """Return whether an order, which the robot does not have, may be assigned to it."""
        if not 0 <= order < self._released or self.taken[order] != NONE or self._is_lost[order]:
            return False
        return bool(self._is_open[order]) or int(self.orders.robot[order]) == robot

    def _withdraw(self, order: int) -> None:
        """Remove an order from those that wait without a robot."""
        if self._is_open[order]:
            self._open -= 1
            self._is_open[order] = False  # ``_due_first`` drops it from the heap later
            self._count(int(self.orders.pickup[order]), -1)
        else:
            reserved = self._reserved[int(self.orders.robot[order])]
            reserved.remove((int(self.orders.due[order]), order))
            heapify(reserved)

    def _count(self, cell: int, more: int) -> None:
        self.waiting_at[cell] += more
        self.changed[1].add(cell)

    def _give(self, robot: int, order: int) -> None:
        self.order_of[robot] = order
        self.changed[0].add(robot)

    def _state(self, order: int) -> str:
        if not 0 <= order < self._released:
            return f"{self._released} orders have been released"
        if self.taken[order] != NONE:
            return f"robot {self.taken_by[order]} has taken it"
        if self._is_lost[order]:
            return "it is lost"
        robot = int(self.orders.robot[order])
        return f"it waits for robot {np.argmax(self.order_of == order) if robot == OPEN else robot}"
