"""Goals that PIBT reaches a step in a lifelong run, without lanes, with lanes and learned costs."""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs, learned_costs
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import random_layout
from warehouse_core.world.generators import kiva_warehouse

STEPS, SEEDS, FIRST_TRIAL = 256, range(10), 100
"""The costs are learned from trials with other seeds, and so with other starts and goals."""

TARGETS = {32: 1.1, 64: 2.25, 96: 3.1, 128: 4.2, 160: 4.9, 192: 6.0}


def throughput(graph: Graph, robots: int, **cells: np.ndarray) -> tuple[float, str]:
    """Return the mean goals a step, and that in words with the time of a step."""
    planner = PIBT(graph)
    runs = [run_lifelong(graph, planner, robots, STEPS, seed, **cells) for seed in SEEDS]
    mean = float(np.mean([run.throughput for run in runs]))
    error = np.std([run.throughput for run in runs], ddof=1) / len(runs) ** 0.5
    milliseconds = 1000 * np.median([run.seconds for run in runs])
    return mean, f"{mean:.2f} ± {1.96 * error:.2f} ({milliseconds:.1f} ms)"


@pytest.mark.parametrize("robots", TARGETS)
def test_goals_a_step_in_a_warehouse(robots: int, measured) -> None:
    layout, starts, goals = kiva_warehouse()
    cells = {"starts": starts, "goals": goals}
    learned = learned_costs(layout, robots, steps=STEPS, seed=FIRST_TRIAL, **cells)
    costs = {"PIBT": None, "lanes": lane_costs(layout), "learned": learned}
    found = {name: throughput(Graph(layout, each), robots, **cells) for name, each in costs.items()}
    words = "; ".join(f"{name} {text}" for name, (_, text) in found.items())
    measured(f"goals a step, 33 x 46 warehouse, {robots} robots", words)
    assert found["learned"][0] >= TARGETS[robots]


@pytest.mark.parametrize("robots", [50, 150])
def test_goals_a_step_on_random_maps(robots: int, measured) -> None:
    found = []
    for seed in range(3):
        layout = random_layout(32, 32, 0.15, seed)
        learned = learned_costs(layout, robots, steps=STEPS, seed=FIRST_TRIAL)
        every = [None, lane_costs(layout), learned]
        found.append([throughput(Graph(layout, costs), robots)[0] for costs in every])
    plain, lanes, learned = np.mean(found, 0)
    measured(
        f"goals a step, 32 x 32 cells, 15% walls, {robots} robots",
        f"PIBT {plain:.2f}; lanes {lanes:.2f}; learned {learned:.2f}",
    )
