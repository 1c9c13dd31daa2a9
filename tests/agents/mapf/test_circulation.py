"""Circulations: joint steps for which an auction chooses the moves of all robots."""

from functools import partial

import numpy as np
import pytest
from helpers.mapf_problems import random_problem, situation
from helpers.mapf_runs import check_headed_planner, check_planner

from agents.mapf import circulation
from agents.mapf.circulation import Circulation, dead_ends, kept_aims, waits_for_exits
from agents.mapf.graph import Graph
from agents.mapf.kernels.places import NONE
from agents.mapf.lifelong import run_lifelong
from agents.mapf.planner import NO_CELLS, Situation
from agents.mapf.windows import WindowedPlanner
from warehouse_core import Layout, random_layout

RING = Layout(["...", ".#.", "..."])
AROUND = np.array([0, 1, 2, 5, 8, 7, 6, 3])

FULL = random_layout(14, 14, 0.2, seed=2)


def test_steps_follow_the_rules_with_headings_and_without() -> None:
    robots, make = len(FULL.open_cells) - 4, partial(Circulation, seed=1)
    assert check_headed_planner(make, FULL, robots) > 5
    assert check_planner(make, random_problem(FULL, robots, seed=3), 20, seed=4) > 20


def test_robots_on_a_full_ring_turn_and_go_round_together() -> None:
    graph, nobody = Graph(RING), np.zeros(8, np.bool_)
    cells, goals, headings = AROUND, np.roll(AROUND, -1), np.ones(8, np.intp)
    planner = Circulation(graph)
    for step in range(3):
        assert np.array_equal(cells, AROUND), step
        given = Situation(cells, goals, nobody, NO_CELLS)
        headings, cells = np.divmod(planner.next_places(given, headings), graph.size)
    assert np.array_equal(
        cells, goals
    )  # the two robots that face east and drive west have turned twice
    assert np.array_equal(
        Circulation(graph).next_cells(Situation(AROUND, goals, nobody, NO_CELLS)), goals
    )


def test_on_full_floors_circulations_reach_what_others_do_not(monkeypatch) -> None:
    graph = Graph(random_layout(10, 10, 0.1, seed=1))
    planners = Circulation(graph), WindowedPlanner(graph, 4, 4), WindowedPlanner(graph, 4, 4)
    alone = planners[2]._make_rounds
    monkeypatch.setattr(planners[2], "_make_rounds", lambda *given: alone(*given)[:1])
    together, both, one_by_one = (
        run_lifelong(graph, each, 58, 10, seed=1, has_headings=True).reached for each in planners
    )
    assert 2 * one_by_one < together
    assert 1.5 * one_by_one < both


def test_urgent_robots_and_those_that_have_waited_go_first(monkeypatch) -> None:
    graph = Graph(Layout([".....", "##.##", "##.##"]))
    cells, goals = np.array([1, 3]), np.array([7, 12])  # the first is nearer, and would go first
    assert Circulation(graph).next_cells(situation(cells, goals)).tolist() == [2, 3]
    urgent = situation(cells, goals)._replace(urgent=np.array([1]))
    assert Circulation(graph).next_cells(urgent).tolist() == [1, 2]
    monkeypatch.setattr(circulation, "PATIENCE", 1)
    planner = Circulation(graph)
    for _ in range(9):  # both goals are unreachable, then the first robot gets a new one
        planner.next_cells(situation(cells, goals)._replace(closed=np.array([2])))
    planner.next_cells(situation(cells, np.array([1, 12]))._replace(closed=np.array([2])))
    assert planner.next_cells(situation(cells, goals)).tolist() == [1, 2]


def test_a_move_is_given_up_where_others_do_not_clear_the_way() -> None:
    cells, aims = np.array([0, 1, 2, 3, 9]), np.array([1, 2, 3, NONE, 8])
    assert kept_aims(10, cells, aims).tolist() == [NONE, NONE, NONE, NONE, 8]
    assert kept_aims(10, cells[[0, 1, 2, 4]], aims[[0, 1, 2, 4]]).tolist() == [1, 2, 3, 8]


def test_robots_wait_until_others_that_go_elsewhere_have_come_out_of_dead_ends() -> None:
    outward = dead_ends(Graph(Layout(["...", "..#", "#.#", "#.#"])))  # 10 and 7 lead out to 4
    goals, outside = np.array([10, 10, 0]), np.array([4, 3, 1])
    assert waits_for_exits(outward, outside, goals).tolist() == [False, False, False]
    assert waits_for_exits(outward, np.array([4, 3, 7]), goals).tolist() == [True, True, False]
    assert waits_for_exits(outward, np.array([7, 3, 10]), goals).tolist() == [True, True, False]
    assert waits_for_exits(outward, np.array([4, 3, 7]), np.array([10, 10, 7])).tolist() == [0] * 3
    tree = dead_ends(Graph(Layout(["...", "#.#", "#.#"])))
    assert waits_for_exits(tree, np.array([1, 4]), np.array([7, 0])).tolist() == [False, False]


@pytest.mark.parametrize("make", [Circulation, partial(WindowedPlanner, window=6, groups=6)])
def test_robots_that_meet_in_a_dead_end_come_past_each_other(make) -> None:
    graph = Graph(Layout(["......", "......", "##.###", "##.###", "##.###"]))
    planner, cells, goals = make(graph), np.array([14, 20]), np.array([26, 5])
    for _ in range(40):
        cells = planner.next_cells(situation(cells, goals))
        goals = np.where(cells == goals, cells, goals)
    assert cells.tolist() == [26, 5]
    idle = make(graph)
    cells, goals = np.array([0, 14]), np.array([20, 14])
    for _ in range(12):
        cells = idle.next_cells(situation(cells, np.array([20, cells[1]])))
    assert cells[0] == 20


def test_costs_below_a_step_lead_to_the_goal() -> None:
    layout = Layout(["........"])
    graph = Graph(layout, np.full((8, 4), 0.1, np.float32))
    planner, cells = Circulation(graph), np.array([0])
    for _ in range(7):
        cells = planner.next_cells(situation(cells, np.array([7])))
    assert cells.tolist() == [7]
