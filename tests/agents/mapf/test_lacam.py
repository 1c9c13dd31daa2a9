"""LaCAM: it solves every solvable problem, and proves that the others are unsolvable."""

import random
from itertools import permutations, product

import pytest
from helpers.mapf_problems import problem_of, random_problem
from helpers.mapf_validator import plan_conflict, step_conflict

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.lacam import lacam
from agents.mapf.problem import Problem
from warehouse_core import random_layout

SHORT = 30.0
"""Time limit in seconds, more than any of these problems takes."""


def reachable(rows: list[str], starts: tuple[int, ...]) -> set[tuple[int, ...]]:
    """Return all reachable configurations, by trying all joint steps."""
    width = len(rows[0])
    found, left = {starts}, [starts]
    while left:
        before = left.pop()
        beside = [[cell, cell - 1, cell + 1, cell - width, cell + width] for cell in before]
        for after in product(*beside):
            if after not in found and step_conflict(rows, before, after) is None:
                found.add(after)
                left.append(after)
    return found


@pytest.mark.parametrize("rows", [["...", "#.#"], ["..", ".."], ["....", "..##"]])
def test_it_solves_exactly_what_can_be_solved(rows: list[str]) -> None:
    width, stream = len(rows[0]), random.Random(0)
    cells = [r * width + c for r, c in product(range(len(rows)), range(width)) if rows[r][c] == "."]
    starts = stream.sample(cells, 3)
    solvable = reachable(rows, tuple(starts))
    for goals in stream.sample(list(permutations(cells, 3)), 12):
        problem = problem_of(rows, starts, list(goals))
        if goals in solvable:
            assert plan_conflict(rows, starts, goals, lacam(problem, SHORT).cells) is None
        else:
            with pytest.raises(PlanError, match=f"tried all {len(solvable)} configurations"):
                lacam(problem, SHORT)


@pytest.mark.parametrize("seed", range(2))
def test_crowds_get_plans_without_conflicts(seed: int) -> None:
    layout = random_layout(12, 12, 0.2, seed)
    ends = random_problem(layout, 25, seed)
    graph = Graph(layout, lane_costs(layout) if seed % 2 else None)
    plans = [lacam(Problem(graph, ends.starts, ends.goals), SHORT, seed) for _ in range(2)]
    assert plan_conflict(layout.rows, ends.starts, ends.goals, plans[0].cells) is None
    assert (plans[0].cells == plans[1].cells).all()


def test_two_change_places_where_there_is_room() -> None:
    """Both have to go back to a junction at the end of a long corridor.

    Without swaps the search takes 65 steps.
    """
    rows = [".###########", "............", ".###########"]
    starts, goals = [20, 21], [21, 20]
    plan = lacam(problem_of(rows, starts, goals), SHORT)
    assert plan_conflict(rows, starts, goals, plan.cells) is None
    assert plan.makespan <= 50


def test_the_search_ends_in_time() -> None:
    cells = list(range(12))
    swapped = [1, 0, *cells[2:]]
    with pytest.raises(PlanError, match=r"no plan in 0\.2 s"):
        lacam(problem_of(["." * 14], cells, swapped), 0.2)
