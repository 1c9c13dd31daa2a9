"""Task assignment."""

import sys

import numpy as np
import pytest

from agents.mapf.assignment import (
    ASSIGNMENTS,
    KEEP,
    LATE,
    NONE,
    REASSIGNING,
    URGENT,
    Tasks,
    cheapest_matching,
)

FAR = np.inf


def tasks(times: list[list[float]], due: list[int] | None = None, now: int = 0) -> Tasks:
    orders = len(times[0])
    held = np.full(len(times), NONE)
    steps = np.array(due or [1000] * orders)
    return Tasks(np.array(times), np.zeros(orders), steps, now, held)


@pytest.mark.parametrize(
    ("name", "times", "expected"),
    [
        ("fifo", [[3, 1], [4, 9]], [0, 1]),  # the older order has the first choice
        ("nearest", [[3, 1], [4, 9]], [1, 0]),
        ("hungarian", [[3, 1], [4, 9]], [1, 0]),
        ("fifo", [[2, 1], [9, 3]], [0, 1]),
        ("nearest", [[2, 1], [9, 3]], [1, 0]),  # the nearest pair leaves a long distance: 10 in all
        ("hungarian", [[2, 1], [9, 3]], [0, 1]),  # 5 in all
        ("urgent", [[2, 1], [9, 3]], [0, 1]),  # nobody is in a hurry
    ],
)
def test_two_robots_and_two_orders(name, times, expected) -> None:
    assert ASSIGNMENTS[name](tasks(times)).tolist() == expected


@pytest.mark.parametrize("name", ASSIGNMENTS)
def test_unreachable_orders_are_left_out(name: str) -> None:
    assign = ASSIGNMENTS[name]
    assert assign(tasks([[FAR, 5], [FAR, 2]])).tolist() == [NONE, 1]
    assert assign(tasks([[FAR, FAR], [7, FAR]])).tolist() == [NONE, 0]
    assert assign(tasks([[FAR], [FAR]])).tolist() == [NONE, NONE]
    assert assign(tasks([[4, 3, 9]])).tolist() in ([0], [1])
    assert assign(Tasks(np.empty((2, 0)), *np.empty((2, 0)), 0, np.full(2, NONE))).tolist() == [
        NONE,
        NONE,
    ]
    assert assign(Tasks(np.empty((0, 2)), *np.ones((2, 2)), 0, np.full(0, NONE))).shape == (0,)


def test_nearest_first_takes_one_nearest_pair_after_the_other() -> None:
    stream = np.random.default_rng(0)
    for _ in range(200):
        times = stream.integers(1, 9, stream.integers(1, 9, 2)).astype(float)
        times[stream.random(times.shape) < 0.2] = FAR
        left, expected = times.copy(), np.full(len(times), NONE)
        while np.isfinite(left).any():
            robot, order = np.unravel_index(left.argmin(), left.shape)
            expected[robot], left[robot], left[:, order] = order, FAR, FAR
        assert ASSIGNMENTS["nearest"](tasks(times.tolist())).tolist() == expected.tolist()


def test_the_number_of_assigned_orders_counts_more_than_times() -> None:
    assert ASSIGNMENTS["hungarian"](tasks([[1, 500], [2, FAR]])).tolist() == [1, 0]


@pytest.mark.parametrize("name", REASSIGNING)
def test_a_robot_keeps_its_order_unless_another_is_clearly_better(name: str) -> None:
    near = tasks([[9, 9 - KEEP + 0.5], [FAR, FAR]])
    assert ASSIGNMENTS[name](near).tolist() == [1, NONE]
    held = near._replace(held=np.array([0, NONE]))
    assert ASSIGNMENTS[name](held).tolist() == [0, NONE]
    better = held._replace(times=near.times - [[0, 1], [0, 1]])
    assert ASSIGNMENTS[name](better).tolist() == [1, NONE]


def test_an_order_that_is_soon_due_is_worth_a_detour() -> None:
    urgent = ASSIGNMENTS["urgent"]
    near, far = 5.0, 5.0 + URGENT / 2
    assert urgent(tasks([[near, far]], [1000, 1000])).tolist() == [0]
    assert urgent(tasks([[near, far]], [1000, 40])).tolist() == [1]
    assert urgent(tasks([[near, far]], [1000, 40], now=30)).tolist() == [0]  # it is late anyway
    assert urgent(tasks([[near, near + LATE / 2]], [2, 1000])).tolist() == [1]
    assert urgent(tasks([[near, near + LATE + 1]], [2, 1000])).tolist() == [0]


def test_the_trip_decides_whether_an_order_can_be_in_time() -> None:
    order = Tasks(
        np.array([[5.0, 6.0]]), np.array([60.0, 0.0]), np.array([40, 40]), 0, np.array([NONE])
    )
    assert ASSIGNMENTS["urgent"](order).tolist() == [1]
    assert ASSIGNMENTS["hungarian"](order).tolist() == [0]


def test_without_scipy_the_same_rows_and_columns_match_ties_included(monkeypatch) -> None:
    stream = np.random.default_rng(0)
    samples = [stream.integers(-3, span, stream.integers(0, 10, 2)) for span in (0, 1, 3, 99) * 100]
    expected = [cheapest_matching(costs.astype(np.float64)) for costs in samples]
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    for costs, pairs in zip(samples, expected, strict=True):
        assert np.array_equal(cheapest_matching(costs.astype(np.float64)), pairs)
