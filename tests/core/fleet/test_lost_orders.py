"""Orders are lost if a robot with an empty battery holds or blocks them."""

import re
from typing import Any

import pytest

from warehouse_core import FleetEnv, Order, OrderQueue
from warehouse_core.errors import OrderError

pytestmark = pytest.mark.filterwarnings("ignore:0 chargers")

FLOOR = ["P..D", "P..D"]


def after(steps: int, orders: Any, starts: Any = ((0, 0), (1, 1)), **settings: Any) -> FleetEnv:
    """Return a fleet after some steps, when the battery of its first robot is empty."""
    env = FleetEnv(FLOOR, 2, orders=orders, starts=starts, dispatch=False, **settings)
    env.reset(seed=0)
    for _ in range(steps):
        env.step(["WAIT", "WAIT"])
    env._engine.battery[0] = 1
    env.step(["WAIT", "WAIT"])
    assert env.ended[0]
    return env


def test_orders_are_lost_whose_station_a_dead_robot_stands_on_or_that_name_it() -> None:
    blocked, named = Order(0, 50, (0, 0), (0, 3)), [Order(0, 50, (1, 0), (1, 3), 0)] * 2
    env = after(0, [blocked, *named, Order(0, 50, (1, 0), (0, 3)), Order(2, 50, (1, 0), (0, 0))])
    assert (env.open_orders, env.order_of, env.measures.lost) == ([3], [None, None], 3)
    with pytest.raises(OrderError, match=re.escape("cannot be assigned to robot 1: it is lost")):
        env.assign(1, 0)
    env.step(["WAIT", "WAIT"])
    assert env.measures.lost == 4  # the last order is released, and its dropoff is blocked
    for action in ("W", "PICK", "E", "E", "E", "N"):
        env.step(["WAIT", action])
    *_, terminated, truncated, _ = env.step(["WAIT", "DROP"])
    assert (env.measures.delivered, env.measures.lost) == (1, 4)
    assert (terminated.any(), truncated.all()) == (False, True)


def test_an_item_for_a_blocked_dropoff_is_put_aside_and_its_robot_goes_on() -> None:
    orders = [Order(0, 50, (1, 0), (0, 3), 1), Order(0, 60, (1, 0), (1, 3), 1)]
    env = FleetEnv(FLOOR, 2, orders=orders, starts=[(0, 3), (1, 0)], dispatch=False)
    env.reset(seed=0)
    env.step(["WAIT", "PICK"])
    assert (env.loaded, env.order_of) == ([False, True], [None, 0])
    env._engine.battery[0] = 1
    env.step(["WAIT", "WAIT"])
    assert (env.loaded, env.order_of, env.measures.lost) == ([False, False], [None, 1], 1)


def test_a_queue_goes_on_without_the_orders_that_are_lost() -> None:
    env = after(0, OrderQueue(6))
    for _ in range(3):
        env.step(["WAIT", "WAIT"])
    assert 0 < env.measures.lost == env.measures.orders - 6
    assert {env.orders[number].pickup for number in env.open_orders} <= {(1, 0), (0, 0)}


def test_a_robot_whose_order_is_lost_gets_its_next() -> None:
    orders = [Order(0, 50, (0, 0), (0, 3)), Order(0, 60, (1, 0), (1, 3), 1)]
    env = FleetEnv(FLOOR, 2, orders=orders, starts=[(0, 0), (1, 1)], dispatch=False)
    env.reset(seed=0)
    env.assign(1, None)
    env.assign(1, 0)
    env._engine.battery[0] = 1
    env.step(["WAIT", "WAIT"])
    assert (env.order_of, env.open_orders, env.measures.lost) == ([None, 1], [], 1)
