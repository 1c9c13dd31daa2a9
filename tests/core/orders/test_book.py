import random
from typing import Any

import numpy as np
import pytest

from warehouse_core import Layout, Order, OrderError
from warehouse_core.orders.book import NEVER, NONE, OrderBook
from warehouse_core.orders.sources import ListedOrders

HALL = Layout(["......"] * 3)
A, B, C = (0, 0), (0, 3), (2, 5)
AT_A, AT_B, AT_C = 0, 3, 17


def book_of(*orders: Order, robots: int = 3, step: int = 0) -> OrderBook:
    source = ListedOrders(orders, HALL, robots)
    book = OrderBook(source.draw(np.random.default_rng(0)), robots, HALL)
    book.release(step)
    return book


def order(pickup: Any = A, due: int = 50, released: int = 0, robot: int | None = None) -> Order:
    return Order(released, due, pickup, (1, 1), robot)


def test_orders_appear_when_they_are_released() -> None:
    book = book_of(order(), order(released=3), order(released=3))
    assert (book.open_orders, book.next_release) == ([0], 3)
    book.release(2)
    assert len(book.records()) == 1
    book.release(3)
    assert (book.open_orders, book.next_release, book.waiting_at[AT_A]) == ([0, 1, 2], NEVER, 3)


def test_of_the_open_orders_at_a_cell_the_first_due_is_taken_and_of_those_the_oldest() -> None:
    book = book_of(order(due=30), order(due=20), order(B, due=1), order(due=20))
    for robot, expected in enumerate((1, 3, 0)):
        assert book.take(robot, AT_A, step=7)
        assert book.order_of[robot] == expected
    assert not book.take(0, AT_C, step=8)
    assert book.records()[1] == order(due=20)._replace(taken_by=0, taken=7)
    assert (book.open_orders, book.waiting_at[AT_A], book.waiting_at[AT_B]) == ([2], 0, 1)


def test_a_robot_that_takes_another_order_gives_its_own_back_with_its_age() -> None:
    book = book_of(order(B), order(A), order(C))
    book.assign(0, 0)
    assert book.open_orders == [1, 2]
    assert book.take(0, AT_A, step=1)
    assert (book.order_of[0], book.open_orders) == (1, [0, 2])
    assert book.waiting_at[AT_B] == 1


def test_reserved_orders_wait_for_their_robot_the_first_due_first() -> None:
    orders = [order(due=80, robot=1), order(B, due=30, robot=1), order(C, due=60, robot=1)]
    book = book_of(*orders)
    assert (book.open_orders, book.waiting_at[AT_A]) == ([], 0)
    assert book.order_of.tolist() == [NONE, 1, NONE]
    assert not book.take(0, AT_B, step=1)
    for cell, expected in ((AT_B, 1), (AT_C, 2), (AT_A, 0)):
        assert book.order_of[1] == expected
        assert book.take(1, cell, step=2)
        book.deliver(1, step=3)
    assert book.is_done


def test_a_reserved_order_that_is_given_back_stays_reserved() -> None:
    book = book_of(order(due=80, robot=1), order(B))
    book.assign(1, 1)
    assert book.order_of[1] == 1
    assert book.open_orders == []
    book.assign(1, None)
    assert (book.order_of[1], book.open_orders) == (0, [1])


def test_reserved_orders_keep_their_turns_whichever_is_assigned_first() -> None:
    stream = random.Random(0)
    for _ in range(30):
        dues = stream.sample(range(100), 8)
        book = book_of(*(order(due=due, robot=0) for due in dues))
        chosen = stream.sample(range(8), 3)
        for number in chosen:
            book.assign(0, number)
        done = []
        while book.order_of[0] != NONE:
            assert book.take(0, AT_A, step=1)
            done.append(dues[book.deliver(0, step=2)])
        last = dues[chosen[-1]]
        assert done == [last, *sorted({*dues} - {last})]


def test_assigned_orders_wait_for_their_robot_only() -> None:
    book = book_of(order(), order(B))
    book.assign(0, 0)
    assert not book.take(1, AT_A, step=1)
    book.assign(0, 0)  # again
    book.assign(0, 1)  # in its place
    assert (book.order_of[0], book.open_orders) == (1, [0])
    book.assign(0, None)
    book.assign(0, None)
    assert (book.order_of[0], book.open_orders) == (NONE, [0, 1])
    assert book.take(1, AT_A, step=1)


@pytest.mark.parametrize(
    ("robot", "number", "message"),
    [
        (0, 4, "order 4 cannot be assigned to robot 0: 4 orders have been released"),
        (0, -1, "order -1 cannot be assigned to robot 0: 4 orders have been released"),
        (0, 10**30, "cannot be assigned to robot 0: 4 orders have been released"),
        (0, 0, "order 0 cannot be assigned to robot 0: robot 2 has taken it"),
        (0, 1, "order 1 cannot be assigned to robot 0: it waits for robot 1"),
        (0, 2, "order 2 cannot be assigned to robot 0: it waits for robot 1"),
        (2, 3, "robot 2 carries order 0; it must deliver it first"),
        (2, None, "robot 2 carries order 0; it must deliver it first"),
    ],
)
def test_an_order_that_does_not_wait_for_all_cannot_be_assigned(robot, number, message) -> None:
    book = book_of(order(), order(B), order(robot=1), order(C), order(released=9))
    book.take(2, AT_A, step=0)
    book.assign(1, 1)
    before = repr((book.order_of, book.open_orders, book.records(), book.waiting_at))
    with pytest.raises(OrderError, match=message):
        book.assign(robot, number)
    assert repr((book.order_of, book.open_orders, book.records(), book.waiting_at)) == before


def test_the_oldest_orders_go_to_the_nearest_robots() -> None:
    book = book_of(order(C), order(A), order(A), order(B))
    book.dispatch(np.array([2, 0]), np.array([AT_A, AT_B]))
    assert book.order_of.tolist() == [0, NONE, 1]  # robot 0 is at B, nearer to C
    assert book.open_orders == [2, 3]


def test_what_has_changed_is_kept_until_it_is_read() -> None:
    book = book_of(order(), order(B))
    assert book.changed == (set(), {AT_A, AT_B})
    for each in book.changed:
        each.clear()
    book.assign(2, 1)
    assert book.changed == ({2}, {AT_B})


def test_a_queue_keeps_as_many_orders_as_it_began_with() -> None:
    draws = iter(range(100))

    def more() -> Any:
        source = ListedOrders([order(due=next(draws)), order(B, due=next(draws))], HALL, 1)
        return source.draw(np.random.default_rng(0))

    book = OrderBook(more(), 1, HALL, more)
    for step in range(6):
        book.release(step)
        assert len(book.open_orders) == 2
        assert book.next_release == NEVER
        cell = AT_A if book.waiting_at[AT_A] else AT_B
        assert book.take(0, cell, step)
        assert book.next_release == NEVER, "an order that is carried is not delivered"
        book.deliver(0, step)
