"""Fleets for tests, and agents that control them."""

import warnings
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core import FleetEnv, FleetEpisode, record_fleet_episode
from warehouse_core.world.distances import distances
from warehouse_core.world.generators import shelf_layout
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import MOVE_DELTAS, moved

SHELVES = shelf_layout(2, 2, aisle=2, pickups=2, dropoffs=2, chargers=2)
LINE = Layout(["P...C...D"])


class Couriers:
    """Robots that mostly take a shortest path to the station of their order."""

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed

    def reset(self) -> None:
        self._random, self._distances = np.random.default_rng(self._seed), cache(distances_to)

    def act(self, env: FleetEnv) -> list[str]:
        return [self._action(env, robot) for robot in range(env.settings.robots)]

    def _action(self, env: FleetEnv, robot: int) -> str:
        number, cell = env.order_of[robot], env.cells[robot]
        if self._random.random() < 0.25:
            return str(self._random.choice([*"NESW", "WAIT", "FLY"]))
        if number is None:
            return "WAIT"
        order, loaded = env.orders[number], env.loaded[robot]
        goal = order.dropoff if loaded else order.pickup
        if cell == goal:
            return "DROP" if loaded else "PICK"
        to_goal = self._distances(env.layout, goal)
        open_sides = [
            side for side, delta in MOVE_DELTAS.items() if env.layout.is_open(moved(cell, delta))
        ]
        return min(open_sides, key=lambda side: to_goal[moved(cell, MOVE_DELTAS[side])])


class Choosers(Couriers):
    """Couriers that assign the orders themselves."""

    def act(self, env: FleetEnv) -> list[str]:
        for robot, loaded in enumerate(env.loaded):
            if not loaded and (env.order_of[robot] is None or self._random.random() < 0.05):
                env.assign(robot, self._random.choice([*env.open_orders, None]))
        return super().act(env)


def distances_to(layout: Layout, goal: tuple[int, int]) -> NDArray[np.float64]:
    return distances(layout, [goal])


def fleet_episode(agent: Couriers | None = None, seed: int = 5, **options: Any) -> FleetEpisode:
    """Return an episode of four robots and two people with some deliveries."""
    given = {"orders": 0.3, "people": 2, "max_steps": 80, "battery": 100, **options}
    layout = given.pop("layout", SHELVES)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = FleetEnv(layout, given.pop("robots", 4), **given)
    episode = record_fleet_episode(env, agent or Couriers(), seed=seed)
    env.close()
    return episode
