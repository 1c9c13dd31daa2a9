"""Planners on graphs whose moves have costs, from lanes or from learned traffic."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from inspect import Parameter, Signature, signature
from typing import Any

from agents.fleet.charging import costs_around_chargers
from agents.mapf.graph import Costs, Graph
from agents.mapf.lanes import WRONG_WAY, lane_costs
from agents.mapf.planner import Planner
from agents.mapf.traffic import (
    DIRECTED_TRIALS,
    DIRECTED_WRONG_WAY,
    TRIAL_SEED,
    directed_costs,
    learned_costs,
    station_goals,
)
from warehouse_core import Layout

TRIALS = 16
"""Default number of trial runs from which costs are learned."""


class Guided:
    """Factory of a planner and its graph, which takes the arguments of both."""

    def __init__(
        self, make_planner: Callable[..., Planner], make_graph: Callable[..., Graph]
    ) -> None:
        self._make_planner, self._make_graph = make_planner, make_graph
        self._of_graph = signature(make_graph).parameters
        known = {**self._of_graph, **signature(make_planner).parameters}
        del known["graph"]
        keywords = [each.replace(kind=Parameter.KEYWORD_ONLY) for each in known.values()]
        self.__signature__ = Signature(keywords)  # which the registry reads

    def __call__(self, **given: Any) -> Planner:
        """Return a planner."""
        of_graph = {name: given.pop(name) for name in self._of_graph if name in given}
        # Wrong arguments raise an error here, before the long trials that learn the costs.
        self._make_planner(Graph(of_graph["layout"]), **given)
        return self._make_planner(self._make_graph(**of_graph), **given)


def on_lanes(layout: Layout, wrong_way: float = WRONG_WAY) -> Graph:
    """Return the graph of a floor with the costs of lanes; see ``lane_costs``."""
    return Graph(layout, costs_around_chargers(layout, lane_costs(layout, wrong_way)))


def on_learned(
    layout: Layout, robots: int, trials: int = TRIALS, trial_seed: int = TRIAL_SEED
) -> Graph:
    """Return the graph of a floor with costs learned in trial runs of this many robots.

    Turns cost nothing in the trials.
    """
    costs = learned_fleet_costs(layout, robots, trials, trial_seed)
    return Graph(layout, costs_around_chargers(layout, costs))


def on_directed(
    layout: Layout,
    robots: int,
    wrong_way: float = DIRECTED_WRONG_WAY,
    trials: int = DIRECTED_TRIALS,
    trial_seed: int = TRIAL_SEED,
) -> Graph:
    """Return the graph of a floor with the costs of ``directed_costs``."""
    costs = directed_costs(layout, robots, wrong_way, trials, trial_seed)
    return Graph(layout, costs_around_chargers(layout, costs))


@lru_cache(maxsize=16)
def learned_fleet_costs(layout: Layout, robots: int, trials: int, seed: int) -> Costs:
    """Return ``learned_costs`` for a fleet, whose goals are stations, half of them dropoffs.

    The result is cached for the process and must not be changed.
    """
    if len(layout.open_cells) < 2:
        trials = 0  # nobody can move
    costs = learned_costs(layout, robots, trials, seed=seed, goals=station_goals(layout))
    costs.flags.writeable = False
    return costs
