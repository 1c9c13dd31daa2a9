"""Lifelong runs of planners."""

import numpy as np
import pytest

from agents.errors import PlanError
from agents.mapf.graph import Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core import Layout, random_layout

LAYOUT = random_layout(12, 12, 0.1, 0)
STARTS, GOALS = LAYOUT.open_cells[:20], LAYOUT.open_cells[30:60]


class Straight:
    """A planner that moves a single robot along a corridor."""

    def reset(self) -> None:
        self.resets = getattr(self, "resets", 0) + 1

    def next_cells(self, situation):
        return situation.cells + np.sign(situation.goals - situation.cells)


def test_goals_are_counted_when_they_are_reached_and_replaced_at_random() -> None:
    graph, planner = Graph(Layout(["." * 9])), Straight()
    run = run_lifelong(graph, planner, 1, 40, 0, np.array([4]), np.array([0, 8]))
    assert (planner.resets, run.cells[0, 0]) == (1, 4)
    assert run.cells[4, 0] in {0, 8}
    assert run.reached == 5  # one after 4 steps, then one each 8 steps
    assert run.throughput == 5 / 40
    assert set(run.goals[3:13, 0].tolist()) == {0, 8}


def test_goals_depend_on_the_seed_and_not_on_the_planner() -> None:
    graph = Graph(LAYOUT)
    runs = [run_lifelong(graph, PIBT(graph, seed), 12, 80, 5) for seed in (0, 1)]
    again = run_lifelong(graph, PIBT(graph, 0), 12, 80, 5)
    other = run_lifelong(graph, PIBT(graph, 0), 12, 80, 6)
    assert (again.cells == runs[0].cells).all()
    assert (other.cells[0] != runs[0].cells[0]).any()
    assert (runs[1].cells != runs[0].cells).any()
    for robot in range(12):
        first, second = (list(dict.fromkeys(run.goals[:, robot].tolist())) for run in runs)
        shorter = min(len(first), len(second))
        assert first[:shorter] == second[:shorter]


@pytest.mark.parametrize(
    ("robots", "goals", "named"),
    [
        (0, GOALS, "0 robots; allowed: 1 to 20"),
        (21, GOALS, "21 robots"),
        (3, GOALS[:1], "two goals"),
    ],
)
def test_an_impossible_run_is_explained(robots: int, goals: np.ndarray, named: str) -> None:
    graph = Graph(LAYOUT)
    with pytest.raises(PlanError, match=named):
        run_lifelong(graph, PIBT(graph), robots, 5, 0, STARTS, goals)
