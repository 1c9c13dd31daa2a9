"""Waypoints: planners with little memory for distance fields reach their goals all the same."""

import pytest
from helpers.mapf_problems import situation

from agents.mapf import graph as module
from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import Layout, random_layout

LAYOUT = random_layout(30, 30, 0.2, seed=1)
ROWS = 40


@pytest.fixture(autouse=True)
def _few_fields(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_BYTES", ROWS * 4 * 900)


@pytest.mark.parametrize("kind", [PIBT, Circulation])
def test_few_fields_are_kept_and_robots_reach_almost_as_many_goals(kind: type, monkeypatch) -> None:
    graph = Graph(LAYOUT)
    planner = kind(graph)
    found = run_lifelong(graph, planner, robots=60, steps=60, seed=1)
    assert len(planner.fields.matrix) <= ROWS
    monkeypatch.setattr(module, "MAX_BYTES", 10**9)
    exact = run_lifelong(graph, kind(graph), robots=60, steps=60, seed=1)
    assert found.reached >= 0.85 * exact.reached


def test_robots_with_headings_reach_goals_through_landmarks_too() -> None:
    graph = Graph(LAYOUT)
    planner = Circulation(graph)
    run = run_lifelong(graph, planner, robots=40, steps=100, seed=1, has_headings=True)
    assert len(planner.fields.matrix) <= ROWS // 4
    assert run.reached >= 30


def test_a_robot_that_is_alone_in_its_part_heads_for_its_goal() -> None:
    """No landmark is in its part of the floor, and one goal is unreachable."""
    layout = Layout(["." * 60, "#" * 60, "##..." + "#" * 55])
    planner, cells = PIBT(Graph(layout)), [*range(58), 122, 124]
    goals = [*range(1, 59), 124, 0]
    after = planner.next_cells(situation(cells, goals, (), ())).tolist()
    assert after[-2:] == [123, 124]
