"""Conflict-based search: its costs beside those of pymapf's, and its time; needs the extra bench.

Source: pymapf, https://pypi.org/project/pymapf/.
"""

import time
from statistics import median

import pytest
from helpers.mapf_problems import problem_of, random_problem, random_problems
from helpers.mapf_runs import check_solver
from pymapf import Agent, ConflictBasedSearch, GridMap, MAPFProblem

from agents.errors import PlanError
from agents.mapf.cbs import ConflictTree, solve_cbs
from agents.mapf.eecbs import solve_eecbs
from agents.mapf.problem import Problem
from warehouse_core import random_layout

PROBLEMS, SECONDS = 200, 20.0


def other_cost(problem: Problem) -> int | None:
    """Return the sum of costs of pymapf's plan, or ``None`` if it has none in time."""
    layout = problem.graph.layout
    grid = GridMap([[tile == "#" for tile in row] for row in layout.rows])
    ends = zip(problem.starts, problem.goals, strict=True)
    pairs = [(divmod(start, layout.width), divmod(goal, layout.width)) for start, goal in ends]
    agents = [Agent(str(number), start, goal) for number, (start, goal) in enumerate(pairs)]
    solver = ConflictBasedSearch(max_expansions=10**9, time_limit=5.0)
    solution = solver.solve(MAPFProblem(grid, agents))
    return None if solution is None else solution.sum_of_costs


def test_costs_are_those_of_another_solver(measured) -> None:
    """Random problems that the other solver solves in 5 s, ours in 20 s."""
    equal = undecided = 0
    for problem in random_problems(10 * PROBLEMS, seed=7, max_robots=6):
        cost = other_cost(problem)
        if cost is None:
            undecided += 1
            continue
        plan = solve_cbs(problem, SECONDS)
        assert plan.sum_of_costs == cost, (problem.graph.layout.rows, problem.starts, problem.goals)
        equal += 1
        if equal == PROBLEMS:
            break
    what = "problems of up to 6 robots with the costs of pymapf"
    measured(what, f"{equal} of {equal}; {undecided} more that pymapf did not solve in 5 s")


@pytest.mark.parametrize(("robots", "walls"), [(20, 10), (40, 20)])
def test_seconds_of_conflict_based_search(robots: int, walls: int, measured) -> None:
    """32 x 32 cells inside a border, connected, some walls."""
    times, nodes, late = [], [], 0
    for seed in range(25):
        problem = random_problem(random_layout(34, 34, walls / 100, seed), robots, seed)
        tree, start = ConflictTree(problem), time.process_time()
        try:
            tree.solve(SECONDS)
        except PlanError:
            late += 1
        times.append(time.process_time() - start)
        nodes.append(len(tree.nodes))
    measured(
        f"CPU seconds of conflict-based search, {robots} robots on 25 floors like "
        f"random-32-32-{walls}",
        f"median {median(times):.3f}, worst {max(times):.2f}; worst {max(nodes)} nodes; "
        f"{late} without a plan in {SECONDS:g} s",
    )


def test_seconds_for_two_robots_in_a_corridor(measured) -> None:
    rows = ["...." + wall * 22 + "...." for wall in "#.#"]
    problem = problem_of(rows, [30, 59], [59, 30])
    tree, start = ConflictTree(problem), time.process_time()
    plan = tree.solve(SECONDS)
    took = time.process_time() - start
    figure = f"{took:.3f}, {len(tree.nodes)} nodes, cost {plan.sum_of_costs}"
    measured("CPU seconds of conflict-based search, two robots in a corridor of 22 cells", figure)


def test_costs_within_a_bound(measured) -> None:
    for robots in (60, 100):
        times, shares = [], []
        for seed in range(10):
            problem = random_problem(random_layout(34, 34, 0.2, seed), robots, seed)
            start = time.process_time()
            plan = solve_eecbs(problem, SECONDS, 1.2)
            times.append(time.process_time() - start)
            assert plan.bound is not None
            shares.append(plan.sum_of_costs / plan.bound)
        measured(
            f"ecbs:w=1.2, {robots} robots on 10 floors like random-32-32-20",
            f"CPU seconds: median {median(times):.2f}, worst {max(times):.2f}; cost over the "
            f"proved bound: median {median(shares):.3f}, worst {max(shares):.3f}",
        )


def test_robots_solved_in_ten_seconds(measured) -> None:
    figures = []
    for robots in (30, 40, 50):
        problems = [
            random_problem(random_layout(34, 34, 0.1, seed), robots, seed) for seed in range(5)
        ]
        figures.append(f"{robots} robots {check_solver(solve_cbs, problems, 10.0)} of 5")
    measured("solved by conflict-based search in 10 s, such floors", ", ".join(figures))
