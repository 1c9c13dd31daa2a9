"""Logs of plans for a replay."""

from typing import Any

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.fleet import PlannedFleet
from agents.fleet.planned import PlanLog
from agents.lab.runs.run import run
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Situation
from agents.registry import make_fleet_agent
from warehouse_core import FleetEnv, FleetEpisode, Layout, OrderStream
from warehouse_core.records.plans import NO_PLANS
from warehouse_core.world.named_layouts import find_layout

DEPOT = find_layout("depot")
ROW = Layout(["....."])


def logged(planner: str, log: PlanLog, robots: int = 16, **options: Any) -> FleetEpisode:
    env = FleetEnv(
        DEPOT, robots, orders=OrderStream(0.3), max_steps=60, battery=10_000, dispatch=False
    )
    agent = make_fleet_agent(planner, None, 3, DEPOT, log=log, **options)
    return run(env, agent, 3, name=planner)


@pytest.mark.parametrize("planner", ["windowed", "pibt"])
def test_plans_begin_where_robots_are_and_robots_mostly_go_as_planned(planner: str) -> None:
    log = PlanLog(range(16))
    episode = logged(planner, log)
    assert len(log.plans) == episode.steps
    cells = [DEPOT.cells(row) for row in episode.cells]
    kept, longest = [], 0
    for step, (ways, wishes, _) in enumerate(log.plans):
        assert [*ways] == [*wishes] == [*range(16)]
        for robot, way in ways.items():
            driven = [before[robot] for before in cells[step : step + 3]]
            assert list(way[:2]) == driven[:2]
            assert wishes[robot][0] == way[-1]
            kept += [list(way[:3]) == driven] if len(way) > 3 and len(driven) == 3 else []
            longest = max(longest, len(way))
    assert longest == 2 if planner == "pibt" else longest > 10
    assert not kept if planner == "pibt" else np.mean(kept) > 0.8


def test_the_wish_of_a_robot_is_the_cheapest_path_to_its_goal() -> None:
    layout = Layout(["....", ".##.", "...."])
    graph, log = Graph(layout, lane_costs(layout)), PlanLog([0])
    log.add(PIBT(graph), Graph(layout), situation([11], [0]), np.array([10]))
    [(ways, wishes, pushers)] = log.plans
    assert ways == {0: [(2, 3), (2, 2)]}
    assert (wishes, pushers) == ({0: [(2, 2), (2, 3), (1, 3), (0, 3), (0, 2), (0, 1), (0, 0)]}, {})
    assert graph.path(3, 3) == [3]
    assert Graph(Layout(["..#.."])).path(0, 4) == [0]


def test_a_robot_that_waits_against_its_plan_has_no_plan_any_more() -> None:
    class Plans:
        def plan_of(self, robot: int) -> list[int]:
            return [1, 2, 3]

    log = PlanLog([0])
    for chosen in (1, 0):
        log.add(Plans(), Graph(ROW), situation([0], [4]), np.array([chosen]))
    assert [len(each.paths[0]) for each in log.plans] == [4, 2]
    assert log.plans[0].wishes == {0: [(0, 3), (0, 4)]}
    assert log.plans[1].wishes == {0: [(0, col) for col in range(5)]}


def test_each_pushed_robot_is_logged_with_its_pusher() -> None:
    planner, log = PIBT(Graph(ROW)), PlanLog(pushes=True)
    given = situation([1, 2], [4, 2])
    log.add(planner, planner.graph, given, planner.next_cells(given))
    assert log.plans[0].pushers == {1: 0}
    log = PlanLog(pushes=True)
    logged("pibt", log, 40)
    assert sum(len(each.pushers) for each in log.plans) > 10


def test_a_lost_step_has_no_plans() -> None:
    class Fails(PIBT):
        def next_cells(self, situation: Situation) -> Any:
            self.calls = getattr(self, "calls", 0) + 1
            if self.calls == 3:
                raise RuntimeError
            return super().next_cells(situation)

    log = PlanLog([0])
    env = FleetEnv(DEPOT, 2, orders=OrderStream(0.3), max_steps=5, dispatch=False)
    fleet = PlannedFleet(Fails(Graph(DEPOT)), goes_on=True, log=log)
    for _ in range(2):
        fleet.planner.calls = 0  # type: ignore[attr-defined]
        run(env, fleet, 1, name="fails")
        assert [plans == NO_PLANS for plans in log.plans] == [False, False, True, False, False]
