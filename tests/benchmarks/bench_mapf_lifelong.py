"""Goals that planners reach a step in a lifelong run, without lanes, with lanes and learned costs.

On a warehouse of the size of the lifelong one in POGEMA's benchmark. Published there for 64, 128
and 192 robots: Follower 1.96, 3.15 and 3.94; RHCR 2.27, 3.49 and 1.57.
"""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from agents.mapf.planner import BasePlanner
from agents.mapf.traffic import learned_costs
from agents.mapf.windows import WindowedPlanner
from warehouse_core import random_layout
from warehouse_core.world.generators import kiva_warehouse

STEPS, SEEDS, WINDOWED_SEEDS, FIRST_TRIAL = 256, range(10), range(4), 100
"""The costs are learned from trials with other seeds, and so with other starts and goals."""

TARGETS = {32: 1.1, 64: 2.25, 96: 3.1, 128: 4.2, 160: 4.9, 192: 6.0}


def throughput(
    planner: BasePlanner, robots: int, seeds: range = SEEDS, **cells: np.ndarray
) -> tuple[float, str]:
    """Return the mean goals a step, and that in words with the time of a step."""
    runs = [run_lifelong(planner.graph, planner, robots, STEPS, seed, **cells) for seed in seeds]
    mean = float(np.mean([run.throughput for run in runs]))
    error = np.std([run.throughput for run in runs], ddof=1) / len(runs) ** 0.5
    times = 1000 * np.array([run.seconds for run in runs])
    figures = f"{np.median(times):.1f} ms, worst {times.max():.0f}"
    return mean, f"{mean:.2f} ± {1.96 * error:.2f} ({figures})"


@pytest.mark.parametrize("robots", TARGETS)
def test_goals_a_step_in_a_warehouse(robots: int, measured) -> None:
    layout, starts, goals = kiva_warehouse()
    cells = {"starts": starts, "goals": goals}
    learned = learned_costs(layout, robots, steps=STEPS, seed=FIRST_TRIAL, **cells)
    costs = {"PIBT": None, "lanes": lane_costs(layout), "learned": learned}
    found = {
        name: throughput(PIBT(Graph(layout, each)), robots, **cells) for name, each in costs.items()
    }
    words = "; ".join(f"{name} {text}" for name, (_, text) in found.items())
    measured(f"goals a step, 33 x 46 warehouse, {robots} robots", words)
    assert found["learned"][0] >= TARGETS[robots]


@pytest.mark.parametrize("groups", [0, 100])
@pytest.mark.parametrize("robots", [64, 128, 192])
def test_goals_a_step_of_windowed_planning(robots: int, groups: int, measured) -> None:
    layout, starts, goals = kiva_warehouse()
    cells = {"starts": starts, "goals": goals}
    learned = learned_costs(layout, robots, seed=FIRST_TRIAL, **cells)
    found = []
    for name, costs in (("lanes of cost 2", lane_costs(layout, 2.0)), ("learned costs", learned)):
        planner = WindowedPlanner(Graph(layout, costs), groups=groups)
        found.append(f"{name} {throughput(planner, robots, WINDOWED_SEEDS, **cells)[1]}")
    measured(f"goals a step, windowed, {groups} groups, {robots} robots", "; ".join(found))


@pytest.mark.parametrize("robots", [50, 150])
def test_goals_a_step_on_random_maps(robots: int, measured) -> None:
    found = []
    for seed in range(3):
        layout = random_layout(32, 32, 0.15, seed)
        learned = learned_costs(layout, robots, steps=STEPS, seed=FIRST_TRIAL)
        every = [None, lane_costs(layout), learned]
        found.append([throughput(PIBT(Graph(layout, costs)), robots)[0] for costs in every])
    plain, lanes, learned = np.mean(found, 0)
    measured(
        f"goals a step, 32 x 32 cells, 15% walls, {robots} robots",
        f"PIBT {plain:.2f}; lanes {lanes:.2f}; learned {learned:.2f}",
    )
