"""Planners of robots with headings, and the checks of their steps."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from helpers.mapf_runs import check_headed_planner

from agents.errors import AgentError, PlanError
from agents.fleet import PlannedFleet
from agents.mapf.circulation import Circulation
from agents.mapf.graph import Graph
from agents.mapf.pibt import PIBT
from agents.mapf.planner import NO_CELLS, PlacePlanner, Situation, check_turns
from agents.mapf.windows import WindowedPlanner
from warehouse_core import FleetEnv, Layout, random_layout, record_episode, shelf_layout

Make = Callable[[Graph], PlacePlanner]

WINDOWS = [partial(WindowedPlanner, window=8, groups=groups) for groups in (0, 12)]


@pytest.mark.parametrize(("make", "robots"), [*zip(WINDOWS, (30, 12), strict=True)])
def test_steps_of_robots_with_headings_follow_the_rules(make: Make, robots: int) -> None:
    assert check_headed_planner(make, random_layout(14, 14, 0.2, seed=2), robots) > robots / 3


@pytest.mark.parametrize("make", [Circulation, WindowedPlanner])
def test_one_robot_takes_as_many_steps_as_its_distance_with_turns(make: Make) -> None:
    layout = random_layout(12, 12, 0.2, seed=3)
    graph = Graph(layout)
    planner, field = make(graph), Graph(layout, turn_cost=1.0).distances(int(layout.open_cells[0]))
    for cell in layout.open_cells[::15].tolist():
        place, steps = graph.size + cell, 0
        while place % graph.size != layout.open_cells[0]:
            headings, cells = np.divmod(np.array([place]), graph.size)
            goal = layout.open_cells[:1]
            situation = Situation(cells, goal, np.array([False]), NO_CELLS)
            [place] = planner.next_places(situation, headings)
            steps += 1
        assert steps == field[graph.size + cell]


@pytest.mark.parametrize(("make", "backend"), [(Circulation, "physics"), (WindowedPlanner, "grid")])
def test_a_fleet_with_headings_delivers(make: Make, backend: str) -> None:
    layout = shelf_layout(aisle=2, pickups=4, chargers=2)
    env = FleetEnv(
        layout, 6, orders=0.2, max_steps=120, dispatch=False, moves="turn", backend=backend
    )
    shift = record_episode(env, PlannedFleet(make(Graph(layout))), seed=1)
    assert shift.measures.delivered > 5
    assert shift.measures.blocked_by_robot == shift.measures.blocked_by_wall == 0


def test_a_planner_without_headings_is_refused() -> None:
    layout = shelf_layout(aisle=2)
    env = FleetEnv(layout, 2, orders=0.1, dispatch=False, moves="turn", seed=1)
    env.reset()
    with pytest.raises(AgentError, match=r"^planner PIBT does not support headings"):
        PlannedFleet(PIBT(Graph(layout))).act(env)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (2, "robot 0 heads east at (0, 1) and is to be at (0, 2), heading north"),
        (3 + 0, "robot 0 heads east at (0, 1) and is to be at (0, 0), heading east"),
        (9 + 1, "robot 0 heads east at (0, 1) and is to be at (0, 1), heading west"),
        (12, "robot 0 heads east at (0, 1) and is to be at (0, 0), heading 4"),
    ],
)
def test_a_step_that_no_robot_can_take_is_refused(place: int, message: str) -> None:
    graph, cell, east = Graph(Layout(["..."])), np.array([1]), np.array([1])
    situation = Situation(cell, cell, np.array([False]), NO_CELLS)
    with pytest.raises(PlanError) as caught:
        check_turns(graph, situation, east, np.array([place]))
    assert str(caught.value) == message
    with pytest.raises(PlanError, match="needed: a place for each of 1 robots"):
        check_turns(graph, situation, east, [1.5])
