"""Costs of moves learned from traffic."""

import numpy as np
import pytest

from agents.errors import PlanError
from agents.mapf import traffic
from agents.mapf.circulation import Circulation
from agents.mapf.graph import CLOSED, Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from agents.mapf.traffic import (
    Directions,
    directed_costs,
    directions,
    learned_costs,
    station_goals,
)
from warehouse_core import Layout, random_layout

NORTH, EAST, SOUTH, WEST, WAIT = range(5)


def test_traffic_is_counted_by_cell_and_move() -> None:
    graph = Graph(Layout(["...", "..."]))
    cells = np.array([[0, 5], [1, 5], [1, 2], [0, 2]])
    counts = traffic.traffic(graph, cells)
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


def test_a_move_costs_more_the_more_robots_move_against_it() -> None:
    directions = Directions(Layout(["...."]), wrong_way=9.0)
    assert directions.costs[1].tolist() == [1, 1, 3, 3]
    directions.add(np.array([[0, 3], [1, 3], [0, 2], [1, 2], [2, 1], [2, 0]]))
    east, west = directions.costs[:3, EAST], directions.costs[1:, WEST]
    assert east.tolist() == pytest.approx(
        [3, 3, 8.9]
    )  # between 0 and 1 two robots move in each direction
    assert west.tolist() == pytest.approx([3, 3, 1])


def test_full_floors_are_made_one_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traffic, "DIRECTED_STEPS", 50)
    directions.cache_clear()
    layout = random_layout(12, 12, 0.1, seed=1)
    costs = directed_costs(layout, 81, trials=3)
    directions.cache_clear()
    graph, plain = Graph(layout, costs), Graph(layout)
    reached = graph.neighbours[:, :WAIT]
    is_move, opposite = reached != CLOSED, np.roll(np.arange(WAIT), 2)
    least, most = np.sort([costs[is_move], costs[reached, opposite][is_move]], axis=0)
    assert np.mean(most > 2 * least) > 0.5
    before, after = (
        sum(
            run_lifelong(each, Circulation(each), 81, 40, seed, has_headings=True).reached
            for seed in range(3)
        )
        for each in (plain, graph)
    )
    assert after > 1.05 * before


def test_robots_go_to_pickups_and_dropoffs_as_often() -> None:
    layout = Layout(["PP..", "..D."])
    goals = station_goals(layout)
    assert goals is not None
    assert sorted(goals.tolist()) == [0, 1, 6, 6]
    assert station_goals(Layout(["...."])) is None


def test_directions_are_found_once_for_the_same_arguments(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(traffic, "DIRECTED_STEPS", 20)
    directions.cache_clear()
    layout = Layout(["....", ".##.", "...."])
    costs = directed_costs(layout, 6, trials=2)
    assert directed_costs(layout, 6, trials=2) is costs
    assert costs.max() <= traffic.DIRECTED_WRONG_WAY
    assert not np.array_equal(directed_costs(layout, 6, trials=2, trial_seed=5), costs)
    with pytest.raises(ValueError, match="read-only"):
        costs[0] = 1
    with pytest.raises(ValueError, match=r"wrong_way .* 0\.5"):
        directed_costs(layout, 6, wrong_way=0.5)
    directions.cache_clear()
