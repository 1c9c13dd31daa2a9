"""Graphs of layouts, and the distances in them."""

import numpy as np
import pytest

from agents.mapf import graph as module
from agents.mapf.graph import CLOSED, FAR, Fields, Graph
from agents.mapf.lanes import lane_costs
from warehouse_core import Layout, random_layout

ROOM = Layout(["..#.", "....", "##.#"])


def test_neighbours_are_north_east_south_west_and_the_cell_itself() -> None:
    graph = Graph(ROOM)
    assert graph.neighbours[5].tolist() == [1, 6, CLOSED, 4, 5]
    assert graph.neighbours[0].tolist() == [CLOSED, 1, 4, CLOSED, 0]
    assert graph.neighbours[2].tolist() == [CLOSED] * 5


def test_fields_that_were_not_used_lately_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = Graph(ROOM)
    monkeypatch.setattr(module, "MAX_BYTES", 2 * graph.distances(0).nbytes)
    kept = graph.distances(0)
    graph.distances(1)
    assert graph.distances(0) is kept
    graph.distances(4)
    assert graph.distances(0) is kept


def test_rows_of_goals_that_nobody_has_are_used_again(monkeypatch: pytest.MonkeyPatch) -> None:
    layout = random_layout(20, 20, 0.1, 0)
    graph = Graph(layout)
    fields, cells = Fields(graph), layout.open_cells
    monkeypatch.setattr(module, "MAX_BYTES", 64 * fields.matrix[:1].nbytes + 1)
    for start in range(0, 240, 40):
        goals = cells[start : start + 60]
        rows = fields.rows(goals)
        for goal, row in zip(goals.tolist(), rows.tolist(), strict=True):
            expected = np.minimum(graph.distances(goal), FAR)
            assert fields.matrix[row].tolist() == expected.tolist()
    assert len(fields.matrix) <= 160


@pytest.mark.parametrize("cost", [1.5, 30_000.0])
def test_distances_that_need_it_are_kept_as_floats(cost: float) -> None:
    layout = Layout(["....", "..#."])
    graph = Graph(layout, lane_costs(layout, cost))
    fields = Fields(graph)
    for goal in (0, 3, 7):
        row = fields.rows(np.array([goal]))[0]
        expected = graph.distances(goal)
        reachable = np.isfinite(expected)
        assert fields.matrix[row][reachable].tolist() == expected[reachable].tolist()
    assert fields.matrix[row][6] == FAR
