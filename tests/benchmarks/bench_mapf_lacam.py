"""LaCAM: 400 robots on random maps of 64 x 64 cells, 10% walls."""

import time

import numpy as np
from helpers.mapf_problems import random_problem
from helpers.mapf_validator import plan_conflict

from agents.mapf.lacam import lacam
from warehouse_core import random_layout

ROBOTS, MAPS, LIMIT = 400, 10, 10.0


def test_four_hundred_robots(measured) -> None:
    times, ratios = [], []
    for seed in range(MAPS):
        layout, start = random_layout(64, 64, 0.1, seed), time.perf_counter()
        problem = random_problem(layout, ROBOTS, seed)
        plan, ends = lacam(problem, LIMIT), (problem.starts, problem.goals)
        times.append(time.perf_counter() - start)
        assert plan_conflict(layout.rows, *ends, plan.cells.tolist()) is None
        least = sum(problem.graph.distances(goal)[cell] for cell, goal in zip(*ends, strict=True))
        ratios.append(plan.sum_of_costs / least)
    measured(
        f"LaCAM, {ROBOTS} robots, {MAPS} maps of 64 x 64 cells, 10% walls",
        f"all solved and valid; {np.median(times):.1f} s, at most {max(times):.1f} s, with all "
        f"distances; sum of costs {np.mean(ratios):.2f} times that of lone robots",
    )
    assert max(times) < LIMIT
