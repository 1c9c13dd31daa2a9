"""The planner of a problem of the League for which none is named."""

from __future__ import annotations

from collections.abc import Callable

from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.lanes import aisle_costs
from agents.mapf.league.scheduler import CROWD, most_busy
from agents.mapf.planner import HeadedPlanner
from agents.mapf.windows import WindowedPlanner

SHARE, GROUPS = 0.8, 100
"""Share of a step in which ``windowed`` looks for better plans, and most groups of it for each
robot.
"""

PATIENCE = 8
"""Patience of ``windowed``."""

DENSE, DENSE_WINDOW, DENSE_PATIENCE = 0.6, 10, 4
"""Robots for each open cell above which ``windowed`` looks less far ahead, and has less patience
with those that are in the way of others.
"""

WRONG_WAY, TRIES = 2.0, 2.0
"""Cost of a move against a lane of ``epibt-aisles``, which plans for crowds, and the mean number of
times that it lets a robot choose once more.
"""


def epibt_in_aisles(graph: Graph, wrong_way: float, tries: float) -> EPIBT:
    """Return the planner that is called ``epibt-aisles`` elsewhere."""
    return EPIBT(graph.with_costs(aisle_costs(graph.layout, wrong_way)), tries=tries)


PLANNERS: dict[str, Callable[..., HeadedPlanner]] = {
    "epibt-aisles": epibt_in_aisles,
    "windowed": WindowedPlanner,
}


def usual_planner(open_cells: int, robots: int, seconds: float) -> tuple[str, dict[str, float]]:
    """Return one of ``PLANNERS`` and its arguments.

    Args:
        open_cells: number of open cells.
        robots: number of robots.
        seconds: time of the planner and the scheduler for a step.
    """
    if robots > CROWD:
        return "epibt-aisles", {"wrong_way": WRONG_WAY, "tries": TRIES}
    led = min(most_busy(open_cells, robots), robots)
    found = {"groups": GROUPS * robots, "seconds": SHARE * seconds, "led": led}
    if robots > DENSE * open_cells:
        return "windowed", {**found, "window": DENSE_WINDOW, "patience": DENSE_PATIENCE}
    return "windowed", {**found, "patience": PATIENCE}


def make_usual_planner(graph: Graph, robots: int, seconds: float) -> HeadedPlanner:
    """Return a planner of a floor; see ``usual_planner``."""
    name, arguments = usual_planner(len(graph.layout.open_cells), robots, seconds)
    return PLANNERS[name](graph, **arguments)
