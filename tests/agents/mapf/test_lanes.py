"""Lanes as costs of moves."""

from agents.mapf.graph import Graph
from agents.mapf.lanes import lane_costs
from warehouse_core import Layout


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
