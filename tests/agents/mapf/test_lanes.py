"""Lanes as costs of moves."""

import numpy as np
import pytest

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from warehouse_core import Layout, random_layout

NORTH, EAST, SOUTH, WEST = range(4)


def test_rows_run_east_and_west_columns_south_and_north_in_turn() -> None:
    costs = lane_costs(Layout(["..", "..", ".."]), 7).reshape(3, 2, 4)
    assert costs[0, 0].tolist() == [7, 1, 1, 7]
    assert costs[1, 1].tolist() == [1, 7, 7, 1]
    assert costs[2, 1].tolist() == [1, 1, 7, 7]


@pytest.mark.parametrize("seed", range(3))
def test_lanes_cut_nothing_off(seed: int) -> None:
    layout = random_layout(9, 11, 0.4, seed)
    goal = int(layout.open_cells[seed])
    plain, lanes = Graph(layout), Graph(layout, lane_costs(layout))
    assert (np.isfinite(plain.distances(goal)) == np.isfinite(lanes.distances(goal))).all()


def test_robots_that_meet_keep_to_their_lanes() -> None:
    """East along the row above and back along the row below is cheaper than against a lane."""
    graph = Graph(Layout(["." * 9, "." * 9]), lane_costs(Layout(["." * 9, "." * 9])))
    assert graph.distances(8)[0] == 8
    assert graph.distances(0)[8] == 8 + 1 + 5
