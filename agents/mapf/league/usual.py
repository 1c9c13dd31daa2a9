"""The planner of a problem of the League for which none is named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from agents.mapf.circulation import Circulation
from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Costs, Graph
from agents.mapf.lanes import aisle_costs, lane_costs
from agents.mapf.league.scheduler import CROWD, most_busy
from agents.mapf.planner import HeadedPlanner
from agents.mapf.windows import WindowedPlanner
from warehouse_core.world.layout import Layout

SHARE, GROUPS, SAMPLES = 0.8, 100, 1000
"""Share of a step in which ``windowed`` and ``circulation`` look for better plans, most groups of
``windowed`` for each robot, and most plans that ``circulation`` compares.
"""

PATIENCE = 8
"""Patience of ``windowed``."""

DENSE, DENSE_WRONG_WAY = 0.6, 3.0
"""Robots for each open cell above which ``windowed`` plans by circulations on lanes, and the cost
of a move against a lane there.
"""

FULL, FULL_WRONG_WAY = 0.9, 4.0
"""Robots for each open cell above which ``circulation`` plans alone, and the cost of a move against
a lane there.
"""

WRONG_WAY, TRIES = 2.0, 2.0
"""Cost of a move against a lane of ``epibt-aisles``, which plans for crowds, and the mean number of
times that it lets a robot choose once more.
"""


def on_costs(
    make: Callable[..., HeadedPlanner], costs_of: Callable[[Layout, float], Costs]
) -> Callable[..., HeadedPlanner]:
    """Return what makes a planner on lanes, as the registry does for names such as ``-lanes``."""

    def made(graph: Graph, wrong_way: float, **arguments: Any) -> HeadedPlanner:
        return make(graph.with_costs(costs_of(graph.layout, wrong_way)), **arguments)

    return made


PLANNERS: dict[str, Callable[..., HeadedPlanner]] = {
    "circulation-lanes": on_costs(Circulation, lane_costs),
    "epibt-aisles": on_costs(EPIBT, aisle_costs),
    "windowed": WindowedPlanner,
    "windowed-lanes": on_costs(WindowedPlanner, lane_costs),
}


def usual_planner(open_cells: int, robots: int, seconds: float) -> tuple[str, dict[str, float]]:
    """Return one of ``PLANNERS`` and its arguments.

    Args:
        open_cells: number of open cells.
        robots: number of robots.
        seconds: time of the planner and the scheduler for a step.
    """
    density, seconds = robots / open_cells, SHARE * seconds
    if robots > CROWD:
        return "epibt-aisles", {"wrong_way": WRONG_WAY, "tries": TRIES}
    if density > FULL:
        return "circulation-lanes", {
            "wrong_way": FULL_WRONG_WAY, "samples": SAMPLES, "seconds": seconds
        }  # fmt: skip
    led = min(most_busy(open_cells, robots), robots)
    found = {
        "groups": GROUPS * robots, "seconds": seconds, "led": led, "patience": PATIENCE
    }  # fmt: skip
    if density > DENSE:
        return "windowed-lanes", {"wrong_way": DENSE_WRONG_WAY, "circulates": True, **found}
    return "windowed", found


def make_usual_planner(graph: Graph, robots: int, seconds: float) -> HeadedPlanner:
    """Return a planner of a floor; see ``usual_planner``."""
    name, arguments = usual_planner(len(graph.layout.open_cells), robots, seconds)
    return PLANNERS[name](graph, **arguments)
