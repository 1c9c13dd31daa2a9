"""Plans for robots with headings: valid, complete, and optimal if proved."""

import random
from dataclasses import replace

import numpy as np
import pytest
from helpers.mapf_problems import random_problem, random_problems
from helpers.mapf_turns import least_step_cost, turning_conflict

from agents.errors import AgentError, PlanError
from agents.lab.commands.planners.runs import solve_checked
from agents.mapf.anytime import solve_anytime
from agents.mapf.cbs import solve_cbs
from agents.mapf.eecbs import solve_eecbs
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.lacam import lacam, lacam_star, with_turns
from agents.mapf.pibt import PIBT
from agents.mapf.planner import solve_by_steps
from agents.mapf.problem import Plan, Problem
from warehouse_core import Layout, random_layout

HOUR = 3600.0


def headed(problem: Problem, seed: int = 0) -> Problem:
    stream = random.Random(seed)
    return replace(problem, headings=[stream.randrange(4) for _ in problem.starts])


def test_plans_are_the_cheapest_and_there_is_none_only_if_brute_force_finds_none() -> None:
    """Without a plan, LaCAM has tried all cells of the robots."""
    unsolved = 0
    for seed, each in enumerate(random_problems(24, seed=5, max_size=4, max_robots=2)):
        problem = headed(each, seed)
        least = least_step_cost(problem)
        if least is None:
            unsolved += 1
            with pytest.raises(PlanError, match="there is no plan: LaCAM tried all"):
                lacam_star(problem, HOUR)
            continue
        plan = lacam_star(problem, HOUR)
        assert turning_conflict(problem, plan) is None
        assert plan.bound == least <= plan.sum_of_costs
        assert problem.lower_bound <= least
    assert 0 < unsolved < 12


@pytest.mark.parametrize("solve", [lacam, solve_anytime])
@pytest.mark.parametrize("seed", range(2))
def test_crowds_get_plans_without_conflicts(solve, seed: int) -> None:
    layout = random_layout(12, 12, 0.2, seed)
    ends = headed(random_problem(layout, 25, seed), seed)
    problem = replace(ends, graph=Graph(layout, lane_costs(layout) if seed % 2 else None))
    given = {} if solve is lacam else {"trials": 20}
    plans = [solve(problem, HOUR, seed, **given) for _ in range(2)]
    assert turning_conflict(problem, plans[0]) is None
    assert np.array_equal(plans[0].cells, plans[1].cells)
    assert np.array_equal(plans[0].headings, plans[1].headings)
    assert plans[0].sum_of_costs >= problem.lower_bound


def test_robots_that_are_at_their_goals_need_no_step() -> None:
    problem = Problem(Graph(Layout(["..."])), [2, 0], [2, 0], headings=[0, 3])
    for solve in (lacam, lacam_star, solve_anytime):
        plan = solve(problem, HOUR)
        assert (plan.cells.tolist(), plan.headings.tolist()) == ([[2, 0]], [[0, 3]])


@pytest.mark.parametrize(
    ("solve", "name"),
    [
        (solve_cbs, "CBS"),
        (solve_eecbs, "CBS"),
        (
            lambda problem, seconds: solve_by_steps(PIBT(problem.graph), problem, seconds),
            "planner PIBT",
        ),
    ],
)
def test_solvers_without_headings_refuse_them(solve, name: str) -> None:
    problem = Problem(Graph(Layout(["..."])), [0], [2], headings=[1])
    with pytest.raises(PlanError, match=f"^{name} does not support headings"):
        solve(problem, HOUR)


@pytest.mark.parametrize(
    ("headings", "words"),
    [
        ([1], "1 headings; each of 2 robots needs one"),
        ([1, 4], "robot 1: its heading is 4; allowed: 0..3"),
        ([-1, 0], "robot 0: its heading is -1; allowed: 0..3"),
    ],
)
def test_invalid_headings_are_refused(headings: list[int], words: str) -> None:
    with pytest.raises(PlanError, match=words):
        Problem(Graph(Layout(["..."])), [0, 1], [2, 0], headings=headings)


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        (Plan.of([[0, 1]]), "it returned headings of the shape None; needed: (2, 1)"),
        (Plan(np.array([[0], [1]]), None, np.array([1])), "it returned headings of the shape (1,)"),
        (
            Plan(np.array([[0], [1]]), None, np.array([[0], [0]])),
            "robot 0 does not head east initially",
        ),
        (
            Plan(np.array([[0], [1]]), None, np.array([[1], [2]])),
            "step 0: robot 0 heads east at (0, 0) and is to be at (0, 1), heading south",
        ),
    ],
)
def test_a_plan_of_a_user_is_checked(plan: Plan, words: str) -> None:
    problem = Problem(Graph(Layout(["..."])), [0], [1], headings=[1])
    with pytest.raises(AgentError) as caught:
        solve_checked("mine", lambda *_: plan, problem, 1.0)
    assert str(caught.value).startswith(f"planner 'mine': {words}")


def test_turns_are_added_to_a_plan_without_headings() -> None:
    problem = Problem(Graph(Layout(["..", ".."])), [0], [3], headings=[0])
    plan = with_turns(problem, Plan(np.array([[0], [1], [3]])))
    assert plan.cells.ravel().tolist() == [0, 0, 1, 1, 3]
    assert plan.headings.ravel().tolist() == [0, 1, 1, 2, 2]
