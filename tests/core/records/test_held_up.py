"""The steps in which robots of a fleet are held up, apart from those in which they have no order.

``tests/core/viz/axes/test_heat_map.py`` has the other rules, by cells.
"""

import numpy as np

from warehouse_core import FleetEnv, FleetEpisode, Layout, Order
from warehouse_core.records import FleetRecorder
from warehouse_core.records.held_up import held_up

ROW = Layout(["P....D"])


def driven(orders: list[Order], actions: str, goes: dict[int, int | None]) -> FleetEpisode:
    """Drive one of two robots by letters, ``-`` to wait; assign it orders before some steps."""
    words = {"p": "PICK", "d": "DROP", "-": "WAIT"}
    env = FleetEnv(ROW, 2, starts=[(0, 1), (0, 3)], orders=orders, max_steps=20, dispatch=not goes)
    recorder = FleetRecorder(env, seed=0)
    for step, action in enumerate(actions):
        if step in goes:
            env.assign(0, goes[step])
        recorder.step([words.get(action, action), "WAIT"])
    return recorder.episode


def steps_of(episode: FleetEpisode) -> list[int]:
    held = held_up(episode)
    assert not held[:, 1].any(), "robot 1 never has an order"
    return np.flatnonzero(held[:, 0]).tolist()


def test_waiting_without_an_order_is_no_hold_up() -> None:
    orders = [Order(2, 20, (0, 0), (0, 5))]
    #                                   released: v
    assert steps_of(driven(orders, "---Wp-E", {})) == [2, 5]


def test_an_assigned_order_counts_from_its_assignment_until_it_is_another_robots_or_done() -> None:
    orders = [Order(0, 20, (0, 0), (0, 5)), Order(0, 20, (0, 0), (0, 5))]
    assert steps_of(driven(orders, "-----", {1: 0, 3: None})) == [1, 2]
    assert steps_of(driven(orders, "--Wp-", {1: 1})) == [1, 4]
    assert steps_of(driven(orders, "--", {0: None})) == []
