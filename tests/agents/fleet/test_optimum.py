"""The optimum of a shift, compared with brute force and with fleets."""

import warnings
from typing import Any

import numpy as np
import pytest

from agents.fleet import optimum
from agents.fleet.optimum import Optimum, most_deliveries
from tests.helpers.fleets import LINE, distances_to
from warehouse_core import (
    Cell,
    Episode,
    FleetEnv,
    Layout,
    Order,
    OrderQueue,
    OrderStream,
    record_fleet_episode,
)


def shift(layout: Layout, robots: int, orders: Any, **settings: Any) -> Episode:
    """Return a shift in which all robots wait."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = FleetEnv(layout, robots, orders=orders, dispatch=False, **settings)
    return record_fleet_episode(env, Waiters(), seed=settings.get("seed", 1))


class Waiters:
    def reset(self) -> None:
        pass

    def act(self, env: FleetEnv) -> list[str]:
        return ["WAIT"] * env.settings.robots


def most_by_trying(record: Episode, on_time: bool) -> int:
    """Return the largest number of deliveries among all sequences of all robots."""
    layout, steps = record.layout, record.steps
    fields = {order.pickup: distances_to(layout, order.pickup) for order in record.orders}
    fields |= {order.dropoff: distances_to(layout, order.dropoff) for order in record.orders}

    def most(robots: list[tuple[Cell, int]], left: frozenset[Order]) -> int:
        best = 0
        for order in left:
            for robot, (cell, step) in enumerate(robots):
                arrived = step + fields[order.pickup][cell]
                taken = max(arrived, order.released) + 1
                delivered = taken + fields[order.dropoff][order.pickup] + 1
                if delivered <= (min(order.due, steps) if on_time else steps):
                    others = robots[:robot] + robots[robot + 1 :]
                    then = [*others, (order.dropoff, int(delivered))]
                    best = max(best, 1 + most(then, left - {order}))
        return best

    starts = layout.cells(record.cells[0])
    return most([(cell, 0) for cell in starts], frozenset(record.orders))


def random_layout(stream: np.random.Generator) -> Layout:
    """Return a small floor, in which some cells may be unreachable."""
    tiles = [*"PPDD", *stream.choice(list("..#"), 20)]
    cells = stream.permutation(tiles).reshape(4, 6)
    return Layout(["".join(row) for row in cells])


def test_most_deliveries_equal_brute_force(monkeypatch: pytest.MonkeyPatch) -> None:
    stream, different = np.random.default_rng(1), 0
    for seed in range(12):
        layout, robots = random_layout(stream), int(stream.integers(1, 4))
        orders = OrderStream(6 / 30, (3, 25))
        record = shift(layout, robots, orders, max_steps=30, seed=seed)
        record.orders = record.orders[:5]
        found = [most_deliveries(record, on_time) for on_time in (False, True)]
        expected = [most_by_trying(record, on_time) for on_time in (False, True)]
        assert found == [Optimum(most, is_exact=True) for most in expected], seed
        different += len({len(record.orders), *expected}) == 3
        with monkeypatch.context() as patch:
            patch.setattr(optimum, "MAX_MOVES", 10)  # time in units of several steps
            bound = most_deliveries(record)
        assert bound.most >= expected[0]
        assert not bound.is_exact or expected[0] == 0
    assert different >= 2


def test_an_optimum_below_the_bound_of_the_relaxation_is_found() -> None:
    layout = Layout([".D.#P.", "P..D..", "..#.#.", "#.#..#"])
    orders = [
        Order(3, 9, (1, 0), (1, 3)),
        Order(4, 15, (1, 0), (0, 1)),
        Order(6, 27, (0, 4), (1, 3)),
        Order(7, 20, (1, 0), (0, 1)),
        Order(21, 39, (1, 0), (1, 3)),
        Order(26, 51, (1, 0), (0, 1)),
    ]
    record = shift(layout, 1, orders, starts=[(1, 1)], max_steps=27)
    most = most_by_trying(record, on_time=True)
    assert most_deliveries(record, on_time=True) == Optimum(most, is_exact=True)


def test_orders_that_nobody_can_deliver() -> None:
    orders = [Order(0, 9, (0, 0), (0, 8)), Order(3, 3, (0, 0), (0, 8))]
    record = shift(LINE, 1, orders, starts=[(0, 4)], max_steps=14)
    assert most_deliveries(record) == Optimum(1, is_exact=True)  # 4 to P, 8 to D, 2 in them
    assert most_deliveries(record, on_time=True) == Optimum(0, is_exact=True)
    record.actions = record.actions[:13]
    assert most_deliveries(record) == Optimum(0, is_exact=True)
    record = shift(LINE, 1, [Order(5, 15, (0, 0), (0, 8))], starts=[(0, 0)], max_steps=15)
    assert most_deliveries(record, on_time=True) == Optimum(1, is_exact=True)  # after waiting


def test_orders_that_come_as_others_are_delivered_have_no_optimum() -> None:
    for orders in (OrderQueue(2), None):
        with pytest.raises(ValueError, match=r"^the orders of this shift are .*; an optimum needs"):
            most_deliveries(shift(LINE, 1, orders, max_steps=5))
