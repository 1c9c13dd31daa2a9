"""CBS, compared with brute force, and its conflict tree."""

import pytest
from helpers.mapf_problems import problem_of, random_problem, random_problems, smallest_cost

from agents.errors import PlanError
from agents.mapf import cbs
from agents.mapf.cbs import ConflictTree, solve_cbs
from warehouse_core import random_layout

SECONDS = 30.0


def test_costs_are_optimal() -> None:
    solved = 0
    for problem in random_problems(40, seed=2, max_size=4, max_robots=3):
        rows = problem.graph.layout.rows
        smallest = smallest_cost(rows, problem.starts, problem.goals)
        if smallest is not None:
            plan = solve_cbs(problem, SECONDS)
            assert plan.sum_of_costs == plan.bound == smallest, (rows, problem.starts)
            solved += 1
    assert solved > 25


def test_robots_that_cross_a_wide_floor_take_few_nodes() -> None:
    """All their shortest paths meet. Without pairs of MDDs there are thousands of nodes."""
    rows = ["." * 12] * 12
    tree = ConflictTree(problem_of(rows, [0 * 12 + 1, 1 * 12 + 0], [11 * 12 + 9, 9 * 12 + 11]))
    assert tree.solve(SECONDS).sum_of_costs == 19 + 19 + 1
    assert tree.nodes < 10


def test_robots_that_meet_in_a_long_corridor_take_two_children() -> None:
    """One waits for the other at the end. Without clashes there are as many nodes as delays."""
    rows = ["#..." + "#" * 22 + "...#", "#..." + "." * 22 + "...#", "#..." + "#" * 22 + "...#"]
    width = len(rows[0])
    tree = ConflictTree(problem_of(rows, [width + 1, 2 * width - 2], [2 * width - 2, width + 1]))
    assert tree.solve(SECONDS).sum_of_costs == 2 * 27 + 24
    assert tree.nodes == 3


def test_a_robot_at_its_goal_lets_another_pass() -> None:
    """Robot 1 starts at its goal and leaves it. It must not finish there before that."""
    problem = problem_of([".....", "##.##"], [0, 2], [4, 2])
    assert solve_cbs(problem, SECONDS).sum_of_costs == 4 + 3


def test_closed_cells_are_kept_out_of() -> None:
    problem = problem_of(["...", "...", "..."], [0, 2], [2, 0])
    problem.graph.close(frozenset({1}))
    plan = solve_cbs(problem, SECONDS)
    assert plan.sum_of_costs == smallest_cost([".#.", "...", "..."], [0, 2], [2, 0])


def test_sets_that_were_forgotten_are_made_again(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = random_problem(random_layout(16, 16, 0.2, 3), 12, 3)
    plan = solve_cbs(problem, SECONDS)
    assert plan.sum_of_costs > problem.lower_bound
    monkeypatch.setattr(cbs, "MAX_BYTES", 0)
    monkeypatch.setattr(cbs, "LEAST_KEPT", 1)
    assert solve_cbs(problem, SECONDS).cells.tolist() == plan.cells.tolist()


def test_the_time_limit_is_in_the_message() -> None:
    with pytest.raises(PlanError, match=r"no plan in 0\.05 s and .* of the conflict tree"):
        ConflictTree(problem_of(["...."], [0, 3], [3, 0])).solve(0.05)
