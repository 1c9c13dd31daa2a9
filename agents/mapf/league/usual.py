"""The planner of a problem of the League for which none is named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from agents.mapf.circulation import Circulation
from agents.mapf.epibt import EPIBT
from agents.mapf.graph import Graph
from agents.mapf.lanes import aisle_costs
from agents.mapf.league.scheduler import CROWD, is_full, most_busy
from agents.mapf.planner import HeadedPlanner
from agents.mapf.traffic import directed_costs
from agents.mapf.windows import WindowedPlanner

SHARE, GROUPS, SAMPLES = 0.8, 100, 1000
"""Share of a step in which ``windowed`` and ``circulation`` look for better plans, most groups of
``windowed`` for each robot, and most plans that ``circulation`` compares.
"""

PATIENCE = 8
"""Patience of ``windowed``."""

DENSE, DENSER, RINGS = 0.4, 0.6, 0.9
"""Robots for each open cell above which ``windowed`` plans on a floor that is made one-way, above
which more are led there and a move against the traffic costs more, and above which ``circulation``
plans alone. Where a scheduler chooses tasks that are near, floors are made one-way only above the
second, since the ways round would be longer than many of these tasks.
"""

LED, DENSER_LED = 0.35, 0.44
"""Least number of robots that ``windowed`` leads for each open cell where the problem gives the
tasks, of which many are far, and that above ``DENSER``.
"""

DENSE_WRONG_WAY, DENSER_WRONG_WAY, FULL_WRONG_WAY = 3.0, 4.0, 9.0
"""Costs of a move against all traffic on such floors, and on full ones."""

CHAINS = {"chains": 6}
"""Chains of trials in which such costs are found."""

WRONG_WAY, TRIES = 2.0, 2.0
"""Cost of a move against a lane of ``epibt-aisles``, which plans for crowds, and the mean number of
times that it lets a robot choose once more.
"""

PLANNERS: dict[str, Callable[..., HeadedPlanner]] = {
    "circulation-directed": Circulation,
    "epibt-aisles": EPIBT,
    "windowed": WindowedPlanner,
    "windowed-directed": WindowedPlanner,
}
"""Functions that make a planner from a graph with costs and its other arguments, by name."""


class Usual(NamedTuple):
    """Name of a planner in ``PLANNERS``, arguments of its costs of moves, and its others."""

    name: str
    floor: dict[str, Any]
    others: dict[str, Any]


def usual_planner(
    open_cells: int, robots: int, seconds: float, *, is_scheduled: bool = True
) -> Usual:
    """Return one of ``PLANNERS`` and its arguments.

    Args:
        open_cells: number of open cells.
        robots: number of robots.
        seconds: time of the planner and the scheduler for a step.
        is_scheduled: true if a scheduler chooses tasks, false if the problem does, as in 2023.
    """
    seconds *= SHARE
    if robots > CROWD:
        return Usual("epibt-aisles", {"wrong_way": WRONG_WAY}, {"tries": TRIES})
    if robots > RINGS * open_cells:
        floor, others = {"wrong_way": FULL_WRONG_WAY}, {"samples": SAMPLES, "seconds": seconds}
        return Usual("circulation-directed", floor | CHAINS, others)
    is_denser, led = robots > DENSER * open_cells, most_busy(open_cells, robots)
    if is_denser or not is_scheduled:
        led = max(led, int((DENSER_LED if is_denser else LED) * open_cells))
    others = {
        "groups": GROUPS * robots, "seconds": seconds, "led": min(led, robots),
        "patience": PATIENCE,
    }  # fmt: skip
    if robots <= (DENSER if is_scheduled else DENSE) * open_cells:
        return Usual("windowed", {}, others)
    floor = {"wrong_way": DENSER_WRONG_WAY if is_denser else DENSE_WRONG_WAY}
    if is_full(open_cells, robots):
        floor, others = {"wrong_way": FULL_WRONG_WAY}, {"circulates": True, **others}
    return Usual("windowed-directed", floor | CHAINS, others)


def usual_graph(graph: Graph, robots: int) -> Graph:
    """Return a floor with the costs of ``usual_planner``, which trials may have to find first."""
    name, floor, _ = usual_planner(len(graph.layout.open_cells), robots, 1.0)
    if name.endswith("-directed"):
        return graph.with_costs(directed_costs(graph.layout, robots, **floor))
    return graph.with_costs(aisle_costs(graph.layout, **floor)) if floor else graph


def make_usual_planner(graph: Graph, robots: int, seconds: float) -> HeadedPlanner:
    """Return a planner of a floor with the costs of ``usual_graph``; see ``usual_planner``."""
    name, _, others = usual_planner(len(graph.layout.open_cells), robots, seconds)
    return PLANNERS[name](graph, **others)
