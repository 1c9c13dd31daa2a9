"""Anytime plans: valid, repeatable with a number of trials, and proved for small teams."""

from dataclasses import replace
from math import inf

import pytest
from helpers.mapf_problems import problem_of, random_problem, random_problems
from helpers.mapf_runs import check_solver
from helpers.mapf_validator import plan_conflict

from agents.errors import PlanError
from agents.mapf import anytime as module
from agents.mapf.anytime import solve_anytime
from agents.mapf.cbs import solve_cbs
from agents.mapf.graph import Graph
from agents.mapf.lacam import lacam, lacam_star
from agents.mapf.lns import Refinement
from agents.mapf.problem import Problem
from warehouse_core import Layout, random_layout

HOUR = 3600.0


def test_plans_of_random_problems_are_valid() -> None:
    def solve(problem, seconds):
        return solve_anytime(problem, seconds, trials=20)

    problems = [random_problem(random_layout(9, 9, 0.1, seed), 12, seed) for seed in range(3)]
    assert check_solver(solve, problems, seconds=HOUR) == 3


def test_trials_make_a_plan_cheaper_and_are_repeated() -> None:
    problem = random_problem(random_layout(16, 16, 0.2, seed=2), 50, seed=2)
    first = lacam(problem, HOUR)
    plans = [solve_anytime(problem, HOUR, trials=60) for _ in range(2)]
    assert plans[0].cells.tolist() == plans[1].cells.tolist()
    assert plans[0].sum_of_costs < 0.9 * first.sum_of_costs


@pytest.mark.parametrize("headings", [None, (0,) * 8])
def test_a_plan_in_which_no_robot_is_late_is_not_replanned(headings) -> None:
    problem = random_problem(Layout(["." * 16] * 16), 8, seed=1)
    problem = replace(problem, headings=headings)
    refinement = Refinement(problem, lacam(problem, HOUR))
    assert refinement.run(inf, trials=500) < 500
    assert refinement.plan().sum_of_costs == problem.lower_bound
    assert refinement.run(inf, trials=500) == 0


def test_guidance_makes_the_plan_of_a_crowded_floor_cheaper() -> None:
    problem = random_problem(random_layout(11, 11, 0.1, seed=3), 60, seed=3)
    first = lacam(problem, HOUR)
    assert first.sum_of_costs > module.CROWDED * problem.lower_bound
    assert solve_anytime(problem, HOUR, trials=0).sum_of_costs < 0.8 * first.sum_of_costs


def test_guidance_finds_a_plan_if_the_first_search_finds_none_in_its_share(monkeypatch) -> None:
    monkeypatch.setattr(module, "FIRST_SHARE", 0.0)
    problem = random_problem(random_layout(11, 11, 0.1, seed=3), 60, seed=3)
    plan = solve_anytime(problem, HOUR, trials=0)
    assert (
        plan_conflict(problem.graph.layout.rows, problem.starts, problem.goals, plan.cells) is None
    )
    monkeypatch.setattr(module, "MAX_GUIDED", 0)
    assert solve_anytime(problem, HOUR, trials=0).sum_of_costs > plan.sum_of_costs


@pytest.mark.parametrize("solve", [lacam_star, solve_anytime])
def test_plans_of_small_teams_are_proved(solve) -> None:
    """No plan costs less than the bound."""
    for problem in random_problems(12, seed=8, max_robots=2):
        try:
            least = solve_cbs(problem, 5.0).sum_of_costs
        except PlanError:
            continue
        plan = solve(problem, HOUR)
        assert plan.bound <= least <= plan.sum_of_costs
        if solve is solve_anytime:
            assert plan.sum_of_costs == least


def test_an_unsolvable_problem_is_reported_as_such() -> None:
    problem = problem_of(["...."], [0, 3], [3, 0])
    with pytest.raises(PlanError, match="there is no plan: LaCAM tried all"):
        solve_anytime(problem, HOUR)


def test_no_plan_leads_through_cells_that_are_closed() -> None:
    """A wall of closed cells has one gap, which all robots have to use."""
    layout = Layout(["." * 9] * 5)
    graph, sides = Graph(layout), ([9 * row + column for row in range(5)] for column in (0, 8))
    graph.close(frozenset(9 * row + 4 for row in range(1, 5)))
    west, east = sides
    problem = Problem(graph, west + east, east + west)
    plan = solve_anytime(problem, HOUR, trials=40)
    assert not graph.closed & set(plan.cells.ravel().tolist())
    assert problem.lower_bound == 2 * sum(8 + 2 * row for row in range(5))
