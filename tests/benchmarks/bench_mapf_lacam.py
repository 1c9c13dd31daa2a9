"""LaCAM: 400 robots on random maps of 64 x 64 cells, 10% walls."""

import time

import numpy as np
from helpers.mapf_validator import plan_conflict

from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam
from agents.mapf.problem import Problem
from warehouse_core import random_layout

ROBOTS, MAPS, LIMIT = 400, 10, 10.0


def test_four_hundred_robots(measured) -> None:
    times, ratios = [], []
    for seed in range(MAPS):
        layout, stream = random_layout(64, 64, 0.1, seed), np.random.default_rng(seed)
        starts, goals = (stream.permutation(layout.open_cells)[:ROBOTS].tolist() for _ in range(2))
        start = time.perf_counter()
        problem = Problem(Graph(layout), starts, goals)
        plan = lacam(problem, LIMIT)
        times.append(time.perf_counter() - start)
        assert plan_conflict(layout.rows, starts, goals, plan.cells.tolist()) is None
        least = sum(
            problem.graph.distances(goal)[cell] for cell, goal in zip(starts, goals, strict=True)
        )
        ratios.append(plan.sum_of_costs / least)
    measured(
        f"LaCAM, {ROBOTS} robots, {MAPS} maps of 64 x 64 cells, 10% walls",
        f"all solved and valid; {np.median(times):.1f} s, at most {max(times):.1f} s, with all "
        f"distances; sum of costs {np.mean(ratios):.2f} times that of lone robots",
    )
    assert max(times) < LIMIT
