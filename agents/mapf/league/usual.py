"""The planner of a problem of the League for which none is named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from agents.mapf.circulation import Circulation
from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Costs, Graph
from agents.mapf.lanes import aisle_costs
from agents.mapf.league.scheduler import CROWD, is_full, most_busy
from agents.mapf.planner import HeadedPlanner
from agents.mapf.traffic import TRIAL_LED, TRIAL_PATIENCE, TRIALS, directed_costs
from agents.mapf.windows import WindowedPlanner
from warehouse_core.world.layout import Layout

SHARE, GROUPS, SAMPLES = 0.8, 100, 1000
"""Share of a step in which ``windowed`` and ``circulation`` look for better plans, most groups of
``windowed`` for each robot, and most plans that ``circulation`` compares.
"""

PATIENCE, LED = TRIAL_PATIENCE, TRIAL_LED
"""Patience of ``windowed``, and least number of robots that it leads for each open cell where the
problem gives the tasks, of which many are far, both as in trials.
"""

DENSE, DENSER = 0.4, 0.6
"""Robots for each open cell above which ``windowed`` plans by circulations on a floor that is made
one-way, and above which a move against the traffic costs more there. Where a scheduler chooses
tasks that are near, it does so only above the second, since the ways round would be longer than
many of these tasks. On full floors ``circulation`` plans alone.
"""

DENSE_WRONG_WAY = 3.0
DENSER_WRONG_WAY, FULL_WRONG_WAY = TRIALS["windowed"].wrong_way, TRIALS["circulation"].wrong_way
"""Costs of a move against all traffic on such floors."""

WRONG_WAY, TRIES = 2.0, 2.0
"""Cost of a move against a lane of ``epibt-aisles``, which plans for crowds, and the mean number of
times that it lets a robot choose once more.
"""


def on_costs(
    make: Callable[..., HeadedPlanner], costs_of: Callable[[Layout, int, float], Costs]
) -> Callable[..., HeadedPlanner]:
    """Return what makes a planner with costs of moves, as the registry does by name."""

    def made(graph: Graph, robots: int, wrong_way: float, **arguments: Any) -> HeadedPlanner:
        costs = costs_of(graph.layout, robots, wrong_way)
        return make(graph.with_costs(costs), **arguments)

    return made


def directed_by(planner: str) -> Callable[[Layout, int, float], Costs]:
    """Return ``directed_costs`` by trials of a planner."""
    return lambda layout, robots, wrong_way: directed_costs(layout, robots, planner, wrong_way)


PLANNERS: dict[str, Callable[..., HeadedPlanner]] = {
    "circulation-directed": on_costs(Circulation, directed_by("circulation")),
    "epibt-aisles": on_costs(EPIBT, lambda layout, _, wrong_way: aisle_costs(layout, wrong_way)),
    "windowed": lambda graph, robots, **arguments: WindowedPlanner(graph, **arguments),
    "windowed-directed": on_costs(WindowedPlanner, directed_by("windowed")),
}
"""Functions that make a planner from a graph, the number of robots and its other arguments."""


def usual_planner(
    open_cells: int, robots: int, seconds: float, *, is_scheduled: bool = True
) -> tuple[str, dict[str, float]]:
    """Return one of ``PLANNERS`` and its arguments.

    Args:
        open_cells: number of open cells.
        robots: number of robots.
        seconds: time of the planner and the scheduler for a step.
        is_scheduled: true if a scheduler chooses tasks, false if the problem does, as in 2023.
    """
    seconds *= SHARE
    if robots > CROWD:
        return "epibt-aisles", {"wrong_way": WRONG_WAY, "tries": TRIES}
    if is_full(open_cells, robots):
        return "circulation-directed", {
            "wrong_way": FULL_WRONG_WAY, "samples": SAMPLES, "seconds": seconds
        }  # fmt: skip
    led = most_busy(open_cells, robots)
    if not is_scheduled:
        led = max(led, int(LED * open_cells))
    found = {
        "groups": GROUPS * robots, "seconds": seconds, "led": min(led, robots),
        "patience": PATIENCE,
    }  # fmt: skip
    if robots > (DENSER if is_scheduled else DENSE) * open_cells:
        wrong_way = DENSER_WRONG_WAY if robots > DENSER * open_cells else DENSE_WRONG_WAY
        return "windowed-directed", {"wrong_way": wrong_way, "circulates": True, **found}
    return "windowed", found


def make_usual_planner(graph: Graph, robots: int, seconds: float) -> HeadedPlanner:
    """Return a planner of a floor; see ``usual_planner``."""
    name, arguments = usual_planner(len(graph.layout.open_cells), robots, seconds)
    return PLANNERS[name](graph, robots, **arguments)
