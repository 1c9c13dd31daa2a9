"""Planners whose moves have costs: lanes, or costs learned from traffic."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from agents.fleet.charging import costs_around_chargers
from agents.mapf.graph import Costs, Graph
from agents.mapf.lanes import WRONG_WAY, lane_costs, learned_costs
from agents.mapf.pibt import PIBT
from agents.mapf.prioritised import REPLAN, WINDOW, WindowedPlanner
from warehouse_core import Layout

TRIALS, TRIAL_SEED = 16, 1_000_000
"""Runs that costs are learned from, and seed of the first, which no episode shares."""


def pibt_on_lanes(
    layout: Layout, seed: int = 0, wrong_way: float = WRONG_WAY, turn_cost: float = 0.0
) -> PIBT:
    """Return ``PIBT`` with the costs of lanes, see ``lane_costs``."""
    return PIBT(_lanes(layout, wrong_way), seed, turn_cost)


def windowed_on_lanes(
    layout: Layout,
    seed: int = 0,
    wrong_way: float = WRONG_WAY,
    window: int = WINDOW,
    replan: int = REPLAN,
    groups: int = 0,
    turn_cost: float = 0.0,
) -> WindowedPlanner:
    """Return a ``WindowedPlanner`` with the costs of lanes, see ``lane_costs``."""
    graph = _lanes(layout, wrong_way)
    return WindowedPlanner(graph, window, replan, groups, seed=seed, turn_cost=turn_cost)


def pibt_on_learned(
    layout: Layout,
    robots: int,
    seed: int = 0,
    trials: int = TRIALS,
    trial_seed: int = TRIAL_SEED,
    turn_cost: float = 0.0,
) -> PIBT:
    """Return ``PIBT`` with costs learned from the traffic of so many robots in trial runs.

    In the trials turns cost nothing.
    """
    return PIBT(_learned(layout, robots, trials, trial_seed), seed, turn_cost)


def windowed_on_learned(
    layout: Layout,
    robots: int,
    seed: int = 0,
    trials: int = TRIALS,
    trial_seed: int = TRIAL_SEED,
    window: int = WINDOW,
    replan: int = REPLAN,
    groups: int = 0,
    turn_cost: float = 0.0,
) -> WindowedPlanner:
    """Return a ``WindowedPlanner`` with costs learned as for ``pibt_on_learned``."""
    graph = _learned(layout, robots, trials, trial_seed)
    return WindowedPlanner(graph, window, replan, groups, seed=seed, turn_cost=turn_cost)


def _learned(layout: Layout, robots: int, trials: int, seed: int) -> Graph:
    costs = learned_fleet_costs(layout, robots, trials, seed)
    return Graph(layout, costs_around_chargers(layout, costs))


def _lanes(layout: Layout, wrong_way: float) -> Graph:
    return Graph(layout, costs_around_chargers(layout, lane_costs(layout, wrong_way)))


@lru_cache(maxsize=16)
def learned_fleet_costs(layout: Layout, robots: int, trials: int, seed: int) -> Costs:
    """Return ``learned_costs`` of a fleet, whose goals are stations: half of them dropoffs.

    They are learned once in a process, and are not to be changed.
    """
    pickups, dropoffs = (layout.numbers(cells) for cells in (layout.pickups, layout.dropoffs))
    goals = np.concatenate(
        [np.tile(pickups, max(len(dropoffs), 1)), np.tile(dropoffs, max(len(pickups), 1))]
    )
    known = goals if len(goals) > 1 else None
    costs = learned_costs(layout, robots, trials, seed=seed, goals=known)
    costs.flags.writeable = False
    return costs
