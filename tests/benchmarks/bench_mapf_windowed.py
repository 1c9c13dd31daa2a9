"""Goals that robots reach in a step with windowed planning, and its time.

On a warehouse of the size of the lifelong one in POGEMA's benchmark. Published there for 64, 128
and 192 robots: Follower 1.96, 3.15 and 3.94; RHCR 2.27, 3.49 and 1.57.
"""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs, learned_costs
from agents.mapf.lifelong import run_lifelong
from agents.mapf.prioritised import WindowedPlanner
from warehouse_core.world.generators import kiva_warehouse

STEPS, SEEDS, FIRST_TRIAL = 256, 4, 100
"""The costs are learned from trials with other seeds, and so with other starts and goals."""

LAYOUT, STARTS, GOALS = kiva_warehouse()
COSTS = {
    "lanes of cost 2": lambda robots: lane_costs(LAYOUT, 2.0),
    "learned costs": lambda robots: learned_costs(
        LAYOUT, robots, seed=FIRST_TRIAL, starts=STARTS, goals=GOALS
    ),
}


@pytest.mark.parametrize("costs", COSTS)
@pytest.mark.parametrize("groups", [0, 100])
@pytest.mark.parametrize("robots", [64, 128, 192])
def test_goals_in_a_step(robots: int, groups: int, costs: str, measured) -> None:
    graph = Graph(LAYOUT, COSTS[costs](robots))
    planner = WindowedPlanner(graph, groups=groups)
    runs = [
        run_lifelong(graph, planner, robots, STEPS, seed, STARTS, GOALS) for seed in range(SEEDS)
    ]
    goals = [run.throughput for run in runs]
    seconds = np.mean([run.seconds.sum() for run in runs])
    worst = max(run.seconds.max() for run in runs)
    measured(
        f"goals in a step, Kiva-like map, {robots} robots, windowed, {groups} groups, {costs}",
        f"{np.mean(goals):.2f} ({min(goals):.2f} to {max(goals):.2f}, {SEEDS} seeds); "
        f"{seconds:.1f} s an episode, worst step {worst:.2f} s",
    )
