"""PIBT: small cases by hand, and crowds checked with the rules of a valid step."""

import numpy as np
import pytest
from helpers.mapf_problems import problem_of, random_problem, situation
from helpers.mapf_runs import check_planner
from helpers.mapf_validator import step_conflict

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.kernels.pibt import NOBODY
from agents.mapf.kernels.robots import SPREAD, draw, first_random, mix
from agents.mapf.pibt import PIBT, PlainPIBT
from agents.mapf.planner import solve_by_steps
from agents.mapf.problem import Problem
from warehouse_core import Layout, random_layout

RING = Layout(["...", ".#.", "..."])


def next_cells(planner: PIBT, cells, goals, stays=(), closed=()) -> list[int]:
    """Return the next cells of robots; those in ``stays`` stay."""
    return planner.next_cells(situation(cells, goals, stays, closed)).tolist()


def test_a_ring_turns() -> None:
    """Nobody can move unless all do."""
    cells = [0, 1, 2, 5, 8, 7, 6, 3]
    planner = PIBT(Graph(RING))
    for _ in range(3):
        goals = [*cells[3:], *cells[:3]]
        after = next_cells(planner, cells, goals)
        assert after == [*cells[1:], cells[0]]


def test_one_that_comes_pushes_one_that_is_at_its_goal() -> None:
    planner = PIBT(Graph(Layout(["...", "#.#"])))
    assert next_cells(planner, [0, 1], [2, 1])[0] == 1
    assert planner.pushers.tolist() == [NOBODY, 0]


def test_a_chain_of_three_thousand_is_pushed() -> None:
    length = 3_001
    planner = PIBT(Graph(Layout(["." * length])))
    cells = list(range(length - 1))
    after = next_cells(planner, cells, [length - 1, *cells[1:]])
    assert after == list(range(1, length))
    assert planner.pushers.tolist() == [NOBODY, *range(length - 2)]


def test_goals_that_cannot_be_reached_or_are_shared_do_no_harm() -> None:
    layout = Layout(["..#.", "..#."])
    planner, cells = PIBT(Graph(layout)), [0, 1, 5]
    for _ in range(20):
        after = next_cells(planner, cells, [4, 4, 3])
        assert step_conflict(layout.rows, cells, after) is None
        cells = after
    assert next_cells(planner, [0], [7]) == [0]
    assert next_cells(planner, [0], [2]) == [0]


def test_a_robot_that_waited_longer_goes_first() -> None:
    """Both want the cell in the middle. The robot that left its goal later has to wait."""
    for seed in range(8):
        planner = PIBT(Graph(Layout(["...", "#.#"])), seed)
        next_cells(planner, [0, 2], [1, 2], stays=[0])
        assert next_cells(planner, [0, 2], [4, 4])[0] in {0, 1}
        planner.reset()
        next_cells(planner, [0, 2], [4, 2], stays=[0, 1])
        next_cells(planner, [0, 2], [4, 2], stays=[0, 1])
        assert next_cells(planner, [0, 2], [4, 4])[0] == 1


@pytest.mark.parametrize("wrong_way", [1, 2.5])
@pytest.mark.parametrize("seed", range(2))
def test_crowds_move_by_the_rules(wrong_way: float, seed: int) -> None:
    layout = random_layout(12, 14, 0.15, seed)
    plain = random_problem(layout, 60, seed)
    graph = Graph(layout, lane_costs(layout, wrong_way))
    problem = Problem(graph, plain.starts, plain.goals)
    assert check_planner(lambda graph: PIBT(graph, seed), problem, 60, seed=seed) > 100


def test_a_problem_that_it_does_not_solve_ends_in_time() -> None:
    problem = problem_of(["...."], [1, 2], [2, 1])
    with pytest.raises(PlanError, match=r"no plan after 0\.05 s"):
        solve_by_steps(PIBT(problem.graph), problem, 0.05)


def test_urgent_robots_go_first() -> None:
    corridor = Graph(Layout(["....."]))
    given = situation([1, 2], [4, 0])
    for urgent, after in ((0, [2, 3]), (1, [0, 1])):
        for seed in range(4):
            planner = PIBT(corridor, seed)
            planner.next_cells(given)
            hurried = given._replace(urgent=np.array([urgent]))
            assert planner.next_cells(hurried).tolist() == after


def test_priority_begins_anew_at_a_goal_and_not_when_the_goal_changes() -> None:
    corridor = Graph(Layout(["......."]))
    for seed in range(5):
        planner = PIBT(corridor, seed)
        next_cells(planner, [1, 5], [3, 5])
        assert next_cells(planner, [2, 3], [6, 0]) == [3, 4]
        planner.reset()
        next_cells(planner, [2, 5], [2, 6])
        assert next_cells(planner, [2, 3], [6, 0]) == [1, 2]


def test_robots_back_off_for_one_that_comes_out_behind_the_next() -> None:
    """Two robots, which wait longer, want to reach the dead end from which the third comes."""
    layout = Layout(["....###", "#......", "....###"])
    for seed in range(8):
        planner, cells, goals = PIBT(Graph(layout), seed), [11, 12, 13], [13, 13, 0]
        next_cells(planner, [10, 12, 13], [13, 13, 13])  # the first has waited longest
        for _ in range(30):
            cells = next_cells(planner, cells, goals)
            goals = [0 if cell == goal else goal for cell, goal in zip(cells, goals, strict=True)]
        assert 13 not in goals


@pytest.mark.parametrize("robots", [4, 20, 34])
def test_the_plain_algorithm_chooses_the_cells_of_the_kernel(robots: int) -> None:
    """Robots never swap here, because no cell but a corner has fewer than three neighbours."""
    layout = Layout(["......"] * 6)
    graph, stream = Graph(layout), np.random.default_rng(robots)
    for seed in range(20):
        cells = stream.permutation(layout.open_cells)[:robots].tolist()
        goals = stream.choice(layout.open_cells, robots).tolist()
        ranks = np.random.default_rng(seed).random(robots)
        order = np.argsort(-(ranks + (np.array(cells) != goals)), kind="stable").tolist()
        random = first_random(seed)
        bits = [int(mix(draw(random.copy()) + robot * SPREAD)) for robot in range(robots)]
        plain = PlainPIBT(graph, cells, goals, bits).step(order)
        assert plain == next_cells(PIBT(graph, seed), cells, goals)
