"""Prioritised planning."""

import pytest
from helpers.mapf_problems import problem_of, random_problems
from helpers.mapf_runs import check_solver

from agents.errors import PlanError
from agents.mapf.prioritised import solve_prioritised

BAY = ["....", "#.##"]
"""Cells 0 to 3 in a row, and the bay 5 below 1."""


def test_plans_of_random_problems_are_valid() -> None:
    solved = check_solver(solve_prioritised, random_problems(120, seed=3), seconds=0.1)
    assert solved > 80


def test_who_finds_no_way_becomes_the_first() -> None:
    """Robot 0 has the longest way, and would be in its goal before robot 1 is through."""
    plan = solve_prioritised(problem_of(["....", ".###"], [4, 1], [2, 3]), 10)
    assert plan.costs.tolist() == [3, 2]
    assert solve_prioritised(problem_of([".....", "###.#"], [0, 3], [3, 4]), 10).sum_of_costs == 4
    assert solve_prioritised(problem_of(["....."], [0, 1], [3, 4]), 10).sum_of_costs == 6


def test_problems_without_an_order_of_priorities_end_at_once() -> None:
    message = "no order of priorities has a plan; robot . had no way in the last"
    with pytest.raises(PlanError, match=message):
        solve_prioritised(problem_of(["...."], [0, 3], [3, 0]), 1e9)


def test_the_time_limit_is_said() -> None:
    problem = problem_of(["." * 10], list(range(10)), [1, 0, *range(2, 10)])
    with pytest.raises(PlanError, match=r"no plan in 0 s and 1 order of priorities$"):
        solve_prioritised(problem, 0)
    with pytest.raises(PlanError, match=r"in 0.1 s and .* orders of .*; robot . had no way"):
        solve_prioritised(problem, 0.1)
