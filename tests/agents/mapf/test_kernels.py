"""Kernels, compared with brute force on tiny floors."""

import random
from itertools import product
from math import inf

import numpy as np
import pytest
from helpers.mapf_problems import problem_of, random_problem, situation
from helpers.mapf_turns import least_step_cost
from helpers.mapf_validator import plan_conflict, step_conflict

from agents.errors import PlanError
from agents.mapf.graph import Fields, Graph, HeadedFields
from agents.mapf.guidance import lane_costs
from agents.mapf.kernels import space_time_astar as kernels
from agents.mapf.kernels.buffers import table_of
from agents.mapf.kernels.places import FAR, NONE, measure
from agents.mapf.lacam import lacam, lacam_star
from agents.mapf.lns import Refinement
from agents.mapf.pibt import PIBT
from warehouse_core import Layout, random_layout

HOUR = 3600.0


def is_free(way: list[int], step: int, after: int, others: list[list[int]]) -> bool:
    """Return whether no other robot is in a cell after a step, or swaps cells with this one."""
    return all(
        after != other[step + 1] and not (after == other[step] and way[-1] == other[step + 1])
        for other in others
    )


def cheapest(rows: list[str], start: int, goal: int, others: list[list[int]], is_open: bool):
    """Return the cost of the cheapest path that avoids others, by brute force."""
    width, times = len(rows[0]), len(others[0])
    distances = Graph(Layout(rows)).distances(goal)
    reached = {(start, start == goal): 0}
    best = inf
    for step in range(times):
        for (cell, has_been), cost in reached.items():
            rests = all(other[later] != goal for other in others for later in range(step, times))
            if not is_open and cell == goal and rests:
                best = min(best, step)
            if is_open and step == times - 1:
                best = min(best, cost + (0 if has_been else distances[cell]))
        if step == times - 1:
            return best
        following: dict[tuple[int, bool], float] = {}
        for (cell, has_been), cost in reached.items():
            for after in (cell, cell - 1, cell + 1, cell - width, cell + width):
                if step_conflict(rows, [cell], [after]) is None and is_free(
                    [cell], step, after, others
                ):
                    key = after, has_been or after == goal
                    following[key] = min(following.get(key, inf), cost + (not has_been))
        reached = following
    raise AssertionError


@pytest.mark.parametrize("is_open", [False, True])
def test_path_costs_equal_brute_force(is_open: bool) -> None:
    stream, found = random.Random(2), 0
    for _ in range(60):
        layout = random_layout(6, 5, 0.15, stream.randrange(1000))
        graph, cells = Graph(layout), layout.open_cells.tolist()
        first = stream.sample(cells, 4)
        goal, times = stream.choice(cells), 9
        others, fields = [[cell] for cell in first[1:]], Fields(graph)
        for _ in range(times - 1):
            before = [way[-1] for way in others]
            after = before
            for _ in range(20):
                tried = [
                    stream.choice([cell, *graph.neighbours[cell][:4].tolist()]) for cell in before
                ]
                if min(tried) >= 0 and step_conflict(layout.rows, before, tried) is None:
                    after = tried
                    break
            for way, cell in zip(others, after, strict=True):
                way.append(cell)
        routes = kernels.new_routes(fields.floor, 4, times, is_open)
        places = np.asarray(routes.places).reshape(4, times)
        places[0, 0], places[1:] = first[0], others
        for robot in range(1, 4):
            kernels.reserve(fields.floor, routes, robot, robot + 1)
        routes.goals[0], routes.rows[0] = goal, int(fields.rows(np.array([goal]))[0]) * graph.places
        frontier = kernels.new_frontier(fields.floor, routes)
        arguments = fields.floor, routes, frontier, fields.table, 0
        least = cheapest(layout.rows, first[0], goal, others, is_open)
        cost = kernels.find_route(*arguments, FAR, stream.randrange(4))
        if least == inf:
            assert cost == NONE
            continue
        found += 1
        assert cost == least
        plan = places.T.tolist()
        ends = [goal if not is_open else plan[-1][0], *plan[-1][1:]]
        assert plan_conflict(layout.rows, first, ends, plan) is None
        assert kernels.find_route(*arguments, int(least) - 1, 0) == NONE
    assert found > 30


@pytest.mark.parametrize("wrong_way", [None, 1.3, 5.0])
@pytest.mark.parametrize("kind", [Fields, HeadedFields])
def test_measured_distances_equal_dijkstra(kind: type[Fields], wrong_way: float) -> None:
    layout = random_layout(11, 9, 0.25, seed=4)
    graph = Graph(layout, None if wrong_way is None else lane_costs(layout, wrong_way))
    fields = kind(graph)
    for goal in layout.open_cells[::7].tolist():  # searches reuse their buffers
        beside, size = np.empty_like(fields._beside), fields.graph.size
        measure(fields._reverse, int(fields._number[goal]), table_of(beside))
        found = np.full((fields.graph.places // size, size), FAR)
        found[:, fields._order] = beside.T
        distances = fields.graph.distances(goal) * fields.step
        assert np.array_equal(found.ravel(), np.minimum(np.rint(distances), FAR))


def test_the_proved_cost_equals_brute_force() -> None:
    stream, solved = random.Random(5), 0
    for number in range(16):
        rows = [["....", ".#.."], ["...", "#.#"], ["....."], ["...", ".#.", "..."]][number % 4]
        cells = [
            row * len(rows[0]) + col
            for row, col in product(range(len(rows)), range(len(rows[0])))
            if rows[row][col] == "."
        ]
        robots = 2 + number % 2
        starts, goals = stream.sample(cells, robots), stream.sample(cells, robots)
        problem = problem_of(rows, starts, goals)
        least = least_step_cost(problem)
        if least is None:
            with pytest.raises(PlanError, match="there is no plan"):
                lacam_star(problem, HOUR)
            continue
        solved += 1
        assert lacam_star(problem, HOUR).bound == least
    assert 4 < solved < 16


TREE = ["....", "#.##", "#.##"]
"""A dead end below the second cell of a corridor with two ends."""


@pytest.mark.parametrize(
    ("starts", "goals"), [([0, 3], [3, 0]), ([9, 5], [5, 9]), ([9, 0], [0, 9])]
)
def test_two_change_places_in_a_tree(starts: list[int], goals: list[int]) -> None:
    plan = lacam(problem_of(TREE, starts, goals), HOUR)
    assert plan_conflict(TREE, starts, goals, plan.cells) is None
    assert plan.makespan <= 14
    planner, cells, reached = PIBT(Graph(Layout(TREE))), starts, set[int]()
    for _ in range(20):
        after = planner.next_cells(situation(cells, goals)).tolist()
        assert step_conflict(TREE, cells, after) is None
        cells = after
        reached |= {robot for robot in (0, 1) if cells[robot] == goals[robot]}
    assert reached == {0, 1}


def test_groups_never_make_a_plan_worse_or_invalid() -> None:
    """Each group is checked separately."""
    gains = 0
    for seed in range(3):
        layout = random_layout(9, 9, 0.1, seed)
        problem = random_problem(layout, 18, seed)
        plan = lacam(problem, HOUR)
        refinement, cost = Refinement(problem, plan, seed), plan.sum_of_costs
        for _ in range(40):
            refinement.run(inf, 1)
            plan = refinement.plan()
            ends = problem.starts, problem.goals
            assert plan_conflict(layout.rows, *ends, plan.cells) is None
            assert plan.sum_of_costs <= cost
            gains += plan.sum_of_costs < cost
            cost = plan.sum_of_costs
    assert gains > 10
