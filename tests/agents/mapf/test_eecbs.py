"""Bounded-suboptimal plans, compared with CBS and brute force."""

import pytest
from helpers.mapf_problems import problem_of, random_problem, random_problems, smallest_cost
from helpers.mapf_runs import check_solver

from agents.errors import PlanError
from agents.mapf.cbs import solve_cbs
from agents.mapf.eecbs import ExplicitTree, solve_eecbs
from warehouse_core import random_layout

SECONDS = 30.0


@pytest.mark.parametrize("w", [1.0, 1.3])
def test_the_optimum_is_between_the_bound_and_the_cost(w: float) -> None:
    solved = dearer = 0
    for problem in random_problems(40, seed=3, max_size=4, max_robots=3):
        rows = problem.graph.layout.rows
        smallest = smallest_cost(rows, problem.starts, problem.goals)
        if smallest is not None:
            plan = solve_eecbs(problem, SECONDS, w)
            assert plan.bound is not None
            assert plan.bound <= smallest <= plan.sum_of_costs <= w * plan.bound, (rows, problem)
            solved += 1
            dearer += plan.sum_of_costs > smallest
    assert solved > 25
    assert (dearer > 0) == (w > 1)


@pytest.mark.parametrize("w", [1.02, 1.2])
def test_a_large_team_stays_within_its_bound(w: float) -> None:
    problem = random_problem(random_layout(20, 20, 0.2, 0), 14, 0)
    optimum = solve_cbs(problem, SECONDS).sum_of_costs
    plan = solve_eecbs(problem, SECONDS, w)
    assert plan.bound is not None
    assert problem.lower_bound <= plan.bound <= optimum <= plan.sum_of_costs <= w * plan.bound
    assert check_solver(lambda each, seconds: solve_eecbs(each, seconds, w), [problem], 30) == 1


def test_the_cost_of_conflicts_is_learned() -> None:
    problem = random_problem(random_layout(12, 12, 0.2, 2), 12, 2)
    tree = ExplicitTree(problem, 1.02)
    tree.solve(SECONDS)
    assert tree.nodes == 173  # 149 if nothing is learned, 180 with the wrong sign


def test_the_message_says_what_is_impossible() -> None:
    problem = problem_of(["...."], [0, 3], [3, 0])
    with pytest.raises(ValueError, match=r"w is 0\.9; it must be at least 1"):
        solve_eecbs(problem, SECONDS, 0.9)
    with pytest.raises(PlanError, match=r"no plan in 0\.05 s and .* of the conflict tree"):
        solve_eecbs(problem, 0.05)
