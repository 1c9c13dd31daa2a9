"""Conflict-based search: its costs beside those of pymapf's, and its time; needs the extra bench.

Source: pymapf, https://pypi.org/project/pymapf/.
"""

import time
from statistics import median

from helpers.mapf_problems import random_problem, random_problems
from helpers.mapf_runs import check_solver
from pymapf import Agent, ConflictBasedSearch, GridMap, MAPFProblem

from agents.errors import PlanError
from agents.mapf.cbs import ConflictTree, solve_cbs
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


def test_seconds_for_20_robots(measured) -> None:
    """32 x 32 cells inside a border, 10% walls, connected; ours and pymapf's on the same."""
    times, nodes, late = [], [], 0
    for seed in range(25):
        problem = random_problem(random_layout(34, 34, 0.1, seed), 20, seed)
        tree, start = ConflictTree(problem), time.process_time()
        try:
            tree.solve(SECONDS)
        except PlanError:
            late += 1
        times.append(time.process_time() - start)
        nodes.append(len(tree.nodes))
    measured(
        "seconds of conflict-based search, 20 robots on 25 floors like random-32-32-10",
        f"median {median(times):.3f}, worst {max(times):.2f}; worst {max(nodes)} nodes; "
        f"{late} without a plan in {SECONDS:g} s",
    )


def test_robots_solved_in_ten_seconds(measured) -> None:
    figures = []
    for robots in (30, 40, 50):
        problems = [
            random_problem(random_layout(34, 34, 0.1, seed), robots, seed) for seed in range(5)
        ]
        figures.append(f"{robots} robots {check_solver(solve_cbs, problems, 10.0)} of 5")
    measured("solved by conflict-based search in 10 s, such floors", ", ".join(figures))
