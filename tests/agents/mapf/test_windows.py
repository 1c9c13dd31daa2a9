"""Lifelong planning in windows: small cases by hand, and crowds checked with the rules."""

import numpy as np
import pytest
from helpers.mapf_problems import random_problem, random_problems, situation
from helpers.mapf_runs import check_planner
from helpers.mapf_validator import step_conflict

from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Situation
from agents.mapf.problem import Problem
from agents.mapf.windows import WindowedPlanner
from warehouse_core import Layout, random_layout

BAY = ["....", "#.##"]
"""Cells 0 to 3 in a row, and the bay 5 below 1."""


@pytest.mark.parametrize("options", [{"groups": 5}, {"seconds": 0.0005}])
def test_windowed_steps_are_valid(options: dict[str, float]) -> None:
    def make(graph: Graph) -> WindowedPlanner:
        return WindowedPlanner(graph, window=8, **options)

    reached = [
        check_planner(make, problem, 25, seed=number)
        for number, problem in enumerate(random_problems(8, seed=4, max_robots=16))
    ]
    assert sum(reached) > 25


def test_a_robot_that_is_not_where_planned_is_replanned() -> None:
    planner = WindowedPlanner(Graph(Layout(["......"])))
    planner.next_cells(situation([2, 1], [5, 4]))
    assert planner.next_cells(situation([2, 1], [5, 4])).tolist() == [3, 2]


def test_no_robot_enters_a_closed_cell_but_one_inside_can_leave_or_stay() -> None:
    planner = WindowedPlanner(Graph(Layout(["....", "...."])))
    assert planner.next_cells(situation([0], [3], closed=[1])).tolist() in ([0], [4])
    planner.reset()
    assert planner.next_cells(situation([0], [3], closed=[0])).tolist() == [1]
    planner.reset()
    assert planner.next_cells(situation([0], [0], closed=[0])).tolist() == [0]
    planner.reset()
    given = situation([0, 1], [1, 3], closed=[1])
    assert step_conflict(["....", "...."], [0, 1], planner.next_cells(given), closed=[1]) is None


def test_a_path_is_replanned_before_it_enters_a_closed_cell() -> None:
    planner = WindowedPlanner(Graph(Layout(["....", "...."])))
    assert planner.next_cells(situation([0], [3])).tolist() == [1]
    assert planner.next_cells(situation([1], [3], closed=[2])).tolist() == [5]


def test_a_robot_without_a_goal_gives_way() -> None:
    planner, cells = WindowedPlanner(Graph(Layout(BAY))), [0, 1]
    for _ in range(6):
        cells = planner.next_cells(situation(cells, [3, 1])).tolist()
    assert cells == [3, 1]


def test_robots_that_meet_head_on_push_past() -> None:
    """Neither can pass the other until one of them moves into the bay."""
    planner, cells = WindowedPlanner(Graph(Layout(BAY)), window=6), [0, 3]
    for _ in range(12):
        cells = planner.next_cells(situation(cells, [3, 0])).tolist()
    assert cells == [3, 0]


@pytest.mark.parametrize("window", [1, 10_001])
def test_a_window_has_two_steps_or_more(window: int) -> None:
    with pytest.raises(ValueError, match="window is "):
        WindowedPlanner(Graph(Layout(["..."])), window)


def test_the_states_of_a_window_are_numbers_of_32_bits() -> None:
    layout = Layout(["." * 400] * 500)
    with pytest.raises(ValueError, match="window is 6000; it must be at most 5367"):
        WindowedPlanner(Graph(layout), 6000)


@pytest.mark.parametrize("kind", [PIBT, WindowedPlanner])
def test_no_robots_have_no_cells(kind: type) -> None:
    planner = kind(Graph(Layout(["..."])))
    assert planner.next_cells(situation([], [])).tolist() == []
    assert planner.next_cells(situation([0], [1])).tolist() == [1]


@pytest.mark.parametrize(("wrong_way", "turn_cost"), [(1.04, 0.0), (1.04, 0.37)])
def test_costs_that_are_no_tenths_are_planned_with(wrong_way: float, turn_cost: float) -> None:
    layout = random_layout(8, 8, 0.1, seed=2)
    graph, plain = Graph(layout, lane_costs(layout, wrong_way)), random_problem(layout, 12, seed=2)
    problem = Problem(graph, plain.starts, plain.goals)
    assert check_planner(lambda graph: WindowedPlanner(graph, turn_cost=turn_cost), problem, 20) > 5


def delay_of_first_robot(seed: int, robots: int, urgent: list[int]) -> int:
    """Return by how many steps a robot in a crowd reaches its goal later than it would alone."""
    graph = Graph(random_layout(12, 12, 0.2, seed=1))
    stream = np.random.default_rng(seed)
    cells, goals = (stream.permutation(graph.layout.open_cells)[:robots] for _ in range(2))
    planner, steps = WindowedPlanner(graph), -int(graph.distances(int(goals[0]))[cells[0]])
    nobody, none = np.zeros(robots, np.bool_), np.array([], np.intp)
    while cells[0] != goals[0]:
        hurries = np.array(urgent, np.intp)
        cells = planner.next_cells(Situation(cells, goals, nobody, none, hurries, hurries))
        steps += 1
    return steps


def test_urgent_robots_are_not_delayed_for_others() -> None:
    delays = [
        sum(delay_of_first_robot(seed, 40, urgent) for seed in range(2, 4)) for urgent in ([], [0])
    ]
    assert 2 * delays[1] < delays[0]


def test_all_robots_can_be_urgent() -> None:
    assert delay_of_first_robot(seed=0, robots=3, urgent=[0, 1, 2]) == 0
