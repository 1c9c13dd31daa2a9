"""Robots with headings on random maps of 32 x 32 cells, 20% walls, beside robots without."""

import time
from dataclasses import replace

import numpy as np
import pytest
from helpers.mapf_problems import random_problem
from helpers.mapf_turns import turning_conflict

from agents.mapf.anytime import solve_anytime
from agents.mapf.lacam import lacam
from agents.mapf.problem import Problem
from warehouse_core import random_layout
from warehouse_core.world.moves import EAST

MAPS, LIMIT = 5, 10.0

MOST = {50: 1.08, 100: 1.14, 200: 1.42, 400: 4.8}
"""Sum of costs over its lower bound, at most, after so many seconds, by robots."""

pytestmark = pytest.mark.usefixtures("processor_clock")


@pytest.mark.parametrize("robots", MOST)
def test_plans_of_robots_with_headings(robots: int, measured) -> None:
    plain, times, ratios = [], [], []
    for seed in range(MAPS):
        problem = random_problem(random_layout(32, 32, 0.2, seed), robots, seed)
        plain.append(first_plan(problem, seed)[0])
        problem = replace(problem, headings=[EAST] * robots)
        took, ratio = first_plan(problem, seed)
        times.append(took)
        ratios.append(ratio)
    better = solve_anytime(problem, LIMIT)
    assert turning_conflict(problem, better) is None
    best = better.sum_of_costs / problem.lower_bound
    measured(
        f"LaCAM with headings, {robots} robots, {MAPS} maps of 32 x 32 cells, 20% walls",
        f"all solved and valid; {np.median(times):.3f} s, without headings {np.median(plain):.3f} "
        f"s, with all distances; sum of costs {np.mean(ratios):.2f} times the bound; of the last "
        f"map {ratios[-1]:.2f}, and {best:.2f} by anytime in {LIMIT:g} s",
    )
    assert best <= MOST[robots]
    assert np.median(times) < 10 * np.median(plain)


def first_plan(problem: Problem, seed: int) -> tuple[float, float]:
    """Return the seconds that LaCAM takes, and its sum of costs over the lower bound."""
    start = time.perf_counter()
    plan = lacam(problem, LIMIT, seed)
    took = time.perf_counter() - start
    if problem.headings is not None:
        assert turning_conflict(problem, plan) is None
    return took, plan.sum_of_costs / problem.lower_bound
