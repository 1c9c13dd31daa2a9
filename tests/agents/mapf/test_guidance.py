"""Costs of moves: lanes, and costs learned from traffic."""

import numpy as np
import pytest

from agents.errors import PlanError
from agents.mapf import guidance
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs, learned_costs, station_goals
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import Layout

NORTH, EAST, SOUTH, WEST, WAIT = range(5)


def test_traffic_is_counted_by_cell_and_move() -> None:
    graph = Graph(Layout(["...", "..."]))
    cells = np.array([[0, 5], [1, 5], [1, 2], [0, 2]])
    counts = guidance.traffic(graph, cells)
    expected = np.zeros((6, 5))
    expected[0, EAST] = expected[1, WAIT] = expected[1, WEST] = 1
    expected[5, WAIT] = expected[5, NORTH] = expected[2, WAIT] = 1
    assert (counts * 3).tolist() == expected.tolist()


def test_robots_that_shuttle_learn_to_keep_apart() -> None:
    """Two corridors between two rooms become one-way, one in each direction."""
    rows = ["..........", "..######..", "..######..", ".........."]
    layout = Layout(rows)
    costs = learned_costs(layout, 8, trials=10, steps=60, goals=np.array([0, 9, 30, 39]))
    assert (costs == learned_costs(layout, 8, 10, 60, goals=np.array([0, 9, 30, 39]))).all()
    above, below = (costs.reshape(4, 10, 4)[row, 3:7] for row in (0, 3))
    assert (above[:, EAST] + 1 < above[:, WEST]).all() != (
        above[:, WEST] + 1 < above[:, EAST]
    ).all()
    assert (above[:, EAST] < above[:, WEST]).all() == (below[:, WEST] < below[:, EAST]).all()
    plain, learned = Graph(layout), Graph(layout, costs)
    before, after = (
        sum(run_lifelong(graph, PIBT(graph), 8, 100, seed).reached for seed in range(50, 55))
        for graph in (plain, learned)
    )
    assert after > before


def test_trials_have_the_starts_and_goals_that_are_given() -> None:
    layout = Layout(["...."])
    with pytest.raises(PlanError, match="3 robots; allowed: 1 to 2"):
        learned_costs(layout, 3, starts=np.array([0, 1]))
    with pytest.raises(PlanError, match="at least two goals"):
        learned_costs(layout, 3, goals=np.array([0]))


def test_robots_go_to_pickups_and_dropoffs_as_often() -> None:
    layout = Layout(["PP..", "..D."])
    goals = station_goals(layout)
    assert goals is not None
    assert sorted(goals.tolist()) == [0, 1, 6, 6]
    assert station_goals(Layout(["...."])) is None


# Lanes.


def test_rows_run_east_and_west_columns_south_and_north_in_turn() -> None:
    costs = lane_costs(Layout(["..", "..", ".."]), 7).reshape(3, 2, 4)
    assert costs[0, 0].tolist() == [7, 1, 1, 7]
    assert costs[1, 1].tolist() == [1, 7, 7, 1]
    assert costs[2, 1].tolist() == [1, 1, 7, 7]


def test_robots_that_meet_keep_to_their_lanes() -> None:
    """East along the row above and back along the row below is cheaper than against a lane."""
    graph = Graph(Layout(["." * 9, "." * 9]), lane_costs(Layout(["." * 9, "." * 9])))
    assert graph.distances(8)[0] == 8
    assert graph.distances(0)[8] == 8 + 1 + 5
