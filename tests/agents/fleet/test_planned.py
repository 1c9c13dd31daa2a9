"""Fleets controlled by a planner and an assignment."""

import re
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.mapf_problems import situation

from agents.errors import AgentError, EpisodeError, PlanError
from agents.fleet import PlannedFleet
from agents.fleet.planned import PlanLog, separate
from agents.fleet.scheduler import parking_of
from agents.lab.runs.run import run
from agents.mapf.graph import Graph
from agents.mapf.guidance import lane_costs
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Planner, Situation, check_step
from agents.mapf.windows import WindowedPlanner
from agents.registry import make_fleet_agent
from warehouse_core import (
    FleetEnv,
    FleetEpisode,
    Layout,
    Order,
    OrderQueue,
    OrderStream,
    shelf_layout,
)
from warehouse_core.records.plans import NO_PLANS
from warehouse_core.records.recorder import record_fleet_episode, replay_fleet_episode
from warehouse_core.world.actions import PICK, WAIT
from warehouse_core.world.named_layouts import find_layout
from warehouse_core.world.tables import Integers

ROOM = Layout(["########", "#P....P#", "#......#", "#C....D#", "########"])
LINE = Layout(["P..C.....D"])


class Does:
    """A planner that returns the result of a function, and records the situations."""

    def __init__(self, plan: Callable[[Situation], Any] = lambda given: given.cells) -> None:
        self._plan = plan

    def reset(self) -> None:
        self.seen: list[Situation] = []

    def next_cells(self, situation: Situation) -> Any:
        self.seen.append(situation)
        return self._plan(situation)


def windowed(layout: Layout) -> Does:
    """Return a planner that records the situations."""
    return Does(WindowedPlanner(Graph(layout)).next_cells)


def fleet_of(layout: Layout, robots: int = 2, **settings: Any) -> FleetEnv:
    given = {"orders": OrderStream(0.2), "max_steps": 60, "dispatch": False, **settings}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return FleetEnv(layout, robots, **given)


def begun(env: FleetEnv, planner: Planner | None = None) -> PlannedFleet:
    """Reset a fleet, and return an agent that controls it."""
    agent = PlannedFleet(planner or Does())
    agent.reset()
    env.reset(seed=1)
    return agent


def test_orders_are_assigned_picked_and_dropped() -> None:
    env = fleet_of(ROOM, 1, orders=[Order(0, 50, (1, 1), (3, 6))], starts=[(1, 3)])
    planner = windowed(ROOM)
    episode = record_fleet_episode(env, PlannedFleet(planner), seed=1)
    [order] = episode.orders
    assert (order.taken, order.delivered) == (3, 11)
    assert episode.assignments == [(0, 0, 0)]
    assert [bool(each.stays[0]) for each in planner.seen] == [
        step in (3, 11) for step in range(1, 12)
    ]


@pytest.mark.parametrize(
    ("assignment", "people"), [("fifo", 2), ("nearest", 0), ("hungarian", 2), ("urgent", 0)]
)
def test_a_shift_has_no_blocked_moves_and_is_repeated(assignment: str, people: int) -> None:
    layout = shelf_layout(3, 3, 4, 1, 2, seed=1, pickups=6, dropoffs=3, chargers=4)
    env = fleet_of(layout, 10, orders=OrderQueue(20), people=people, max_steps=80)
    agent = make_fleet_agent("pibt", assignment, 3, layout)
    episode = record_fleet_episode(env, agent, seed=2)
    assert episode.measures.blocked_by_wall == 0
    assert episode.measures.blocked_by_robot == 0 or people
    assert episode.measures.delivered > 7
    assert record_fleet_episode(env, agent, seed=2) == episode
    assert replay_fleet_episode(episode) == episode


def test_a_lone_robot_takes_orders_again_after_it_has_charged() -> None:
    env = fleet_of(ROOM, 1, orders=OrderQueue(2), battery=60, max_steps=300)
    episode = record_fleet_episode(env, PlannedFleet(PIBT(Graph(ROOM))), seed=1)
    assert episode.measures.delivered > 10  # it stopped after 4


def test_the_order_of_a_robot_goes_to_a_nearer_one_until_it_is_picked() -> None:
    orders = [Order(0, 90, (0, 0), (0, 9)), Order(3, 90, (0, 9), (0, 0))]

    def assignments(name: str) -> list[tuple[int, int, int | None]]:
        starts = [(0, 6), (0, 8)]
        env = fleet_of(LINE, 2, orders=orders, starts=starts, max_steps=8)
        return record_fleet_episode(env, PlannedFleet(Does(), name), seed=1).assignments

    assert assignments("hungarian") == [(0, 0, 0), (3, 1, 1)]
    # The first robot heads for the order on the left. The order released later is nearer to it.
    orders = [Order(0, 90, (0, 9), (0, 0)), Order(3, 90, (0, 0), (0, 9))]
    assert assignments("nearest") == [(0, 1, 0), (3, 0, 1)]
    orders = [
        Order(0, 90, (0, 0), (0, 9)),
        Order(0, 90, (0, 1), (0, 9)),
        Order(3, 90, (0, 7), (0, 0)),
    ]
    assert assignments("nearest")[-1][0] == 0
    changed = assignments("hungarian")
    assert changed[0][0] == 0
    assert {each for each in changed if each[0] == 3} == {(3, 1, None), (3, 1, 2)}


def test_a_robot_that_goes_to_charge_gives_its_order_to_another() -> None:
    env = fleet_of(
        LINE, 2, orders=[Order(0, 99, (0, 0), (0, 9))], starts=[(0, 5), (0, 8)], battery=60
    )
    agent = begun(env)
    env.step(agent.act(env))
    assert env.order_of == [0, None]  # both wait
    while env.order_of[0] == 0:
        env._engine.battery[1] = 55
        env.step(agent.act(env))
    assert 30 < env.battery[0] < 36  # it is near the charger
    assert env.order_of == [None, 0]


def test_a_robot_takes_no_order_for_which_its_battery_does_not_last() -> None:
    env = fleet_of(LINE, 1, orders=[Order(0, 99, (0, 0), (0, 9))], starts=[(0, 8)], battery=200)
    for battery, order in (105, None), (106, 0):  # 8 + 9 steps, and 6 to the charger
        agent = begun(env)
        env._engine.battery[0] = battery
        agent.act(env)
        assert env.order_of == [order]


def test_orders_that_nobody_can_reach_wait() -> None:
    split = Layout(["P..#..D", "..D#P.."])
    orders = [
        Order(0, 50, (0, 0), (0, 6)),
        Order(0, 50, (1, 4), (0, 6)),
        Order(0, 50, (0, 0), (1, 2)),
    ]
    env = fleet_of(split, 2, orders=orders, starts=[(0, 1), (0, 5)], max_steps=3)
    record_fleet_episode(env, PlannedFleet(Does()), seed=1)
    assert env.order_of == [2, 1]


def test_robots_without_a_task_leave_stations_and_stay_elsewhere() -> None:
    env = fleet_of(ROOM, 3, orders=0.0, starts=[(1, 1), (2, 3), (3, 6)], max_steps=12)
    record_fleet_episode(env, PlannedFleet(windowed(ROOM)), seed=1)
    stations = {*ROOM.pickups, *ROOM.dropoffs, *ROOM.chargers}
    assert not stations & set(env.cells)
    assert env.cells[1] == (2, 3)
    corridor = parking_of(Layout(["PD.", "###", "P#D"]))
    assert corridor.tolist() == [2, 2, 2, 3, 4, 5, 6, 7, 8]


@pytest.mark.parametrize("backend", ["grid", "driving"])
def test_cells_that_people_are_in_or_leave_or_reach_are_closed(backend: str) -> None:
    env = fleet_of(ROOM, 3, people=3, max_steps=40, backend=backend)
    planner, on_the_way = Does(), 0
    planned = begun(env, planner)
    for _ in range(40):
        env.step(planned.act(env))
        assert backend == "grid" or not any(outcome.contacts for outcome in env.last_motion)
        planned.act(env)
        ends = env.routes.ends[3:]
        on_the_way += set(env.people) != set(ends)
        cells = {row * ROOM.width + col for row, col in (*env.people, *ends)}
        assert set(planner.seen[-1].closed.tolist()) == cells
    assert on_the_way > 10 or backend == "grid"


OPEN = Graph(Layout(["....", "..#.", "...."]))


@pytest.mark.parametrize(
    ("before", "chosen", "message"),
    [
        (situation([0, 2]), [1, 1], "robots 0 and 1 are both to be in (0, 1)"),
        (situation([0, 1]), [1, 0], "robots 0 and 1 are to change places, (0, 0) and (0, 1)"),
        (situation([0]), [2], "robot 0 is to go from (0, 0) to (0, 2), which is not an open cell"),
        (situation([3]), [4], "robot 0 is to go from (0, 3) to (1, 0), which is not an open cell"),
        (situation([0]), [-1], "robot 0 is to go from (0, 0) to (-1, 3), which is not an open"),
        (situation([0, 3], stays=[1]), [0, 2], "robot 1 is to go from (0, 3) to (0, 2), but"),
        (situation([0], closed=[1]), [1], "robot 0 is to enter (0, 1), which is closed"),
        (situation([0, 3]), [0], "the planner returned [0]; needed: a cell number for each of 2"),
        (situation([0]), None, "the planner returned None; needed"),
    ],
)
def test_a_wrong_step_names_robots_and_cells(before, chosen, message) -> None:
    with pytest.raises(PlanError, match=re.escape(message)):
        check_step(OPEN, before, chosen)


def test_a_step_may_follow_and_turn_in_a_ring_and_robots_may_share_a_cell() -> None:
    ring = situation([0, 1, 5, 4])
    assert check_step(OPEN, ring, [1, 5, 4, 0]).tolist() == [1, 5, 4, 0]
    assert check_step(OPEN, situation([0, 1]), (1, 2)).tolist() == [1, 2]
    shared = situation([0, 0, 3], stays=[0, 1], closed=[0])
    assert check_step(OPEN, shared, np.array([0, 0, 2])).tolist() == [0, 0, 2]


def test_the_first_robot_in_a_shared_cell_leaves_it_if_it_can() -> None:
    shared = situation([1, 0, 0, 0], stays=[1, 2, 3])
    assert separate(OPEN, shared, shared.cells).tolist() == [1, 4, 0, 0]
    closed = situation([1, 0, 0], stays=[1, 2], closed=[4])
    assert separate(OPEN, closed, np.array([2, 0, 0])).tolist() == [2, 0, 0]
    planner = Does()
    env = fleet_of(ROOM, 2, orders=[Order(0, 50, (1, 1), (3, 6))], starts=[(1, 1), (1, 2)])
    agent = begun(env, planner)
    env._engine.robots.cells[1] = env._engine.robots.cells[0]
    assert agent.act(env).tolist() == [PICK, WAIT]
    assert planner.seen[0].stays.tolist() == [True, True]


def fail(situation: Situation) -> Integers:
    raise ValueError("no path")


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (fail, r"ValueError: no path \(test_planned.py, line \d+\)"),
        (lambda given: given.cells * 0 + given.cells[0], "PlanError: robots 0 and 1 are both .*"),
    ],
)
def test_a_fault_of_a_planner_stops_the_shift_or_loses_its_step(fault, message) -> None:
    planner = Does(lambda given: fault(given) if len(planner.seen) == 3 else given.cells)
    env = fleet_of(ROOM, starts=[(2, 3), (2, 4)])
    with pytest.raises(EpisodeError, match=f"^seed 7, step 3, agent mine: {message}$"):
        run(env, PlannedFleet(planner), 7, name="mine")
    agent = PlannedFleet(planner, goes_on=True)
    assert run(env, agent, 7, name="mine").steps == 60
    assert [step for step, _ in agent.lost] == list(range(3, 61, 3))  # it is reset each time
    assert re.fullmatch(message, agent.lost[0][1])


def test_a_plan_that_takes_too_long_is_cut_off() -> None:
    def hang(situation: Situation) -> Integers:
        while True:
            time.sleep(0)

    agent = PlannedFleet(Does(hang), seconds=0.05)
    env = fleet_of(ROOM, max_steps=2)
    start = env.reset(seed=1) and env.cells
    run(env, agent, 1, name="mine")
    assert agent.lost == [(step, "the plan took more than 0.05 s") for step in (1, 2)]
    assert env.cells == start


def test_planners_and_agents_of_a_user_are_distinguished(tmp_path: Path) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(
        "class Plans:\n"
        "    def __init__(self, graph, seed, layout, window=3):\n"
        "        self.given = graph, seed, layout, window\n"
        "    def reset(self): ...\n"
        "    def next_cells(self, situation): return situation.cells\n"
        "class Acts:\n"
        "    def reset(self): ...\n"
        "    def act(self, env): ...\n"
        "class Neither:\n"
        "    def reset(self): ...\n"
    )
    planned = make_fleet_agent(f"{mine}:Plans:window=9", "nearest", 5, ROOM)
    assert isinstance(planned, PlannedFleet)
    graph, *rest = planned.planner.given  # type: ignore[attr-defined]
    assert rest == [5, ROOM, 9]
    assert graph.layout == ROOM
    assert type(make_fleet_agent(f"{mine}:Acts")).__name__ == "Acts"
    for name, assignment, message in (
        (f"{mine}:Acts", "urgent", "has act(), so it assigns orders itself; leave out"),
        (f"{mine}:Neither", None, "has no next_cells; needed: reset and next_cells, or reset and"),
        ("nobody", None, "no planner is called 'nobody'; allowed: auto, pibt, windowed, "),
        ("pibt", "soon", "no assignment is called 'soon'; allowed: fifo, nearest, hungarian, urg"),
        ("pibt:window=3", None, "planner 'pibt' takes no argument 'window'; allowed: turn_cost="),
    ):
        with pytest.raises(AgentError, match=re.escape(message)):
            make_fleet_agent(name, assignment, 1, ROOM)
    with pytest.raises(AgentError, match=re.escape("has act(), so it has no plans to show")):
        make_fleet_agent(f"{mine}:Acts", None, 1, ROOM, log=PlanLog([0]))


def test_with_very_many_pairs_orders_are_reassigned_every_few_steps(monkeypatch) -> None:
    monkeypatch.setattr("agents.fleet.scheduler.MAX_PAIRS", 0)
    places = (0, 0), (0, 1), (0, 7)
    orders = [Order(3 * (col == 7), 90, (row, col), (0, 9)) for row, col in places]
    env = fleet_of(LINE, 2, orders=orders, starts=[(0, 6), (0, 8)], max_steps=14)
    episode = record_fleet_episode(env, PlannedFleet(Does(), "hungarian"), seed=1)
    assert {step for step, *_ in episode.assignments} == {0, 10}


# Logs of plans.

DEPOT = find_layout("depot")


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
