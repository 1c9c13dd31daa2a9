"""Teams of agents, their shifts, and the pilot of each robot."""

import random
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.fleet.team import ENOUGH, NEARLY_FULL, PATIENCE, Pilot, Site, Team
from agents.registry import make_team
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import FleetEnv, Layout, Observation, OrderStream
from warehouse_core.fleet import Battery
from warehouse_core.fleet.observation import FleetObservation
from warehouse_core.records.recorder import record_fleet_episode, replay_fleet_episode
from warehouse_core.world.actions import WAIT

ROOM = Layout(["########", "#P....P#", "#......#", "#D....D#", "########"])
MINE = """
import random

LOADED = []
LOADED.append(1)


class Mine:
    def __init__(self, seed, layout):
        self.seed, self.layout = seed, layout
        self.first, self.times_loaded = random.random(), len(LOADED)

    def reset(self): ...
    def act(self, observation): ...
"""


def make_env(robots: int = 3, **settings: Any) -> FleetEnv:
    return FleetEnv(ROOM, robots, orders=OrderStream(0.2), max_steps=60, **settings)


class Fixed:
    """An agent that always takes the same action."""

    reason = "fixed"

    def reset(self) -> None:
        pass

    def act(self, observation: Observation) -> str:
        return "E"


def test_each_robot_has_its_own_agent_and_its_own_reason() -> None:
    env = make_env(2, starts=[(2, 1), (2, 5)])
    env.reset(seed=1)
    while None in env.order_of:
        env.step(["WAIT", "WAIT"])
    team = Team([Fixed(), GreedyAgent(1)])
    assert team.act(env)[0] == 1
    assert team.reason == ["fixed", "greedy"]
    assert team.robot is None


def test_the_same_seed_repeats_a_shift_with_the_same_team_and_a_new_one() -> None:
    env, team = make_env(8), make_team("bfs", 8, 5, ROOM)  # it makes no random moves of its own
    first = record_fleet_episode(env, team, seed=2)
    assert first.measures.delivered >= 4
    assert record_fleet_episode(env, team, seed=2) == first
    assert record_fleet_episode(env, make_team("bfs", 8, 5, ROOM), seed=2) == first
    assert record_fleet_episode(env, make_team("bfs", 8, 6, ROOM), seed=2) != first
    assert replay_fleet_episode(first) == first


def test_the_agents_of_a_team_have_different_seeds_and_see_walls_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MINE)
    [*agents] = make_team(f"{tmp_path / 'mine.py'}:Mine", 3, 7, ROOM).agents
    assert len({agent.seed for agent in agents}) == 3  # type: ignore[attr-defined]
    assert {agent.times_loaded for agent in agents} == {1}  # type: ignore[attr-defined]
    assert len({agent.first for agent in agents}) == 3  # type: ignore[attr-defined]
    assert not agents[0].layout.pickups + agents[0].layout.dropoffs  # type: ignore[attr-defined]
    [lone] = make_team("greedy:memory=3", 1, 7).agents
    assert isinstance(lone, GreedyAgent)
    assert (lone.seed, lone.memory) == (7, 3)
    unseeded = make_team("greedy", 2).agents
    assert [agent.seed for agent in unseeded] == [None, None]  # type: ignore[attr-defined]


class Checked(GreedyAgent):
    """An agent that checks where it acts."""

    places: list[tuple[int, int]]

    def act(self, observation: Observation) -> str:
        self.places = [*getattr(self, "places", []), observation["robot_pos"]]
        return super().act(observation)


def test_agents_of_robots_that_drive_through_act_at_rest() -> None:
    """Each move therefore begins in the observed cell and ends in a neighbour of it."""
    env = make_env(2, backend="driving")
    agents = [Checked(), Checked()]
    episode = record_fleet_episode(env, Team(agents, seed=1), seed=1)
    assert episode.measures.delivered
    for agent in agents:
        steps = [abs(a - c) + abs(b - d) for (a, b), (c, d) in pairwise(agent.places)]
        assert max(steps) == 1
        assert len(agent.places) < 2 * episode.steps / 3
    assert np.array_equal(episode.cells, replay_fleet_episode(episode).cells)


# One robot.


HALL = Layout(["#######", "#P...C#", "#.....#", "#D...C#", "#######"])
EAST, WEST = 1, 3


class Noting:
    """An agent that drives in one direction, and records its observations."""

    def __init__(self, action: object = "W") -> None:
        self.action, self.resets = action, 0
        self.seen: list[Observation] = []

    def reset(self) -> None:
        self.resets += 1

    def act(self, observation: Observation) -> str:
        self.seen.append(observation)
        return self.action  # type: ignore[return-value]


def hall(robots: int = 1, layout: Layout = HALL, **settings: Any) -> Site:
    return Site(FleetEnv(layout, robots, max_steps=500, **settings))


def make_pilot(agent: Noting | None = None, **settings: Any) -> tuple[Pilot, Noting]:
    agent = agent or Noting()
    return Pilot(agent, hall(**settings), random.Random(1)), agent


def seen(**changed: object) -> FleetObservation:
    """Return the observation of a robot in the middle of the room."""
    observation: dict[str, object] = {
        "local_grid": [".....", ".....", "..R..", ".....", "....."],
        "robot_pos": (2, 3),
        "has_item": False,
        "battery": 200,
        "steps": 0,
        "pickup_pos": (1, 1),
        "dropoff_pos": (3, 1),
        "due": 50,
        "charger_pos": (1, 5),
    }
    return observation | changed  # type: ignore[return-value]


def test_the_agent_gets_the_goal_of_the_order_and_is_reset_for_each() -> None:
    pilot, agent = make_pilot()
    assert pilot.act(seen()) == WEST
    pilot.act(seen(robot_pos=(2, 2)))
    pilot.act(seen(robot_pos=(2, 1), has_item=True, pickup_pos=None))
    assert agent.resets == 1  # one order is one episode, its pick included
    pilot.act(seen(dropoff_pos=(3, 3)))
    assert agent.resets == 2
    goals = [(each["pickup_pos"], each["dropoff_pos"]) for each in agent.seen]
    assert goals == [((1, 1), (3, 1)), ((1, 1), (3, 1)), (None, (3, 1)), ((1, 1), (3, 3))]


@pytest.mark.parametrize("has_item", [False, True])
def test_a_robot_drives_to_a_charger_in_time_and_stays_until_nearly_full(has_item: bool) -> None:
    pilot, agent = make_pilot()
    goal = {"has_item": has_item, "pickup_pos": None if has_item else (1, 1)}
    reserve = hall().reserve((2, 3))
    assert reserve == 2 * 3 + 10
    pilot.act(seen(battery=16, **goal))
    assert agent.seen[-1]["dropoff_pos"] == (3, 1)
    pilot.act(seen(battery=15, **goal))
    assert (agent.seen[-1]["pickup_pos"], agent.seen[-1]["dropoff_pos"]) == ((1, 5), (1, 5))
    assert agent.seen[-1]["has_item"] is has_item
    full = int(NEARLY_FULL * 200)
    for battery in (13, full - 1):
        assert pilot.act(seen(robot_pos=(1, 5), battery=battery, **goal)) == WAIT
        assert pilot.reason == "charges"
    assert pilot.act(seen(robot_pos=(1, 5), battery=full, **goal)) == WEST
    assert agent.seen[-1]["dropoff_pos"] == (3, 1)


def test_more_robots_than_chargers_go_earlier_but_none_with_enough() -> None:
    one, two, three, four = (hall(robots, battery=400).reserve((2, 3)) for robots in range(1, 5))
    assert one == two < three < four
    assert hall(8, battery=100).reserve((2, 3)) == ENOUGH * 100


def test_a_robot_without_an_order_waits_but_leaves_stations_and_goes_to_charge() -> None:
    pilot, agent = make_pilot()
    idle = {"pickup_pos": None, "dropoff_pos": None}
    assert pilot.act(seen(**idle)) == WAIT
    assert pilot.reason == "no order"
    for cell in (*HALL.pickups, *HALL.dropoffs, *HALL.chargers):
        assert pilot.act(seen(robot_pos=cell, **idle)) < WAIT
        assert pilot.reason == "leaves a station"
    assert not agent.seen
    pilot.act(seen(battery=int(ENOUGH * 200) - 1, **idle))
    assert agent.seen[-1]["pickup_pos"] == (1, 5)


def test_a_robot_that_makes_way_avoids_others_and_stations() -> None:
    pilot, _ = make_pilot(layout=Layout(["PPD", "PP.", "PPP"]))
    idle = {"pickup_pos": None, "dropoff_pos": None, "robot_pos": (1, 1)}
    beside = {pilot.act(seen(local_grid=["...", ".R.", "..."], **idle)) for _ in range(20)}
    assert beside == {EAST}
    others = {pilot.act(seen(local_grid=[".O.", "oR#", ".H."], **idle)) for _ in range(20)}
    assert (others, pilot.reason) == ({WAIT}, "shut in")
    onto = {pilot.act(seen(local_grid=[".O.", ".R#", ".H."], **idle)) for _ in range(20)}
    assert onto == {WEST}
    blind = {pilot.act(seen(local_grid=["R"], **idle)) for _ in range(20)}
    assert blind == {EAST}


def test_a_robot_that_cannot_move_gives_way_after_some_steps() -> None:
    pilot, agent = make_pilot()
    actions = [pilot.act(seen(local_grid=["...", "OR#", ".#."])) for _ in range(PATIENCE + 2)]
    assert actions == [WEST] * PATIENCE + [0, WEST]
    agent.action = "WAIT"  # a robot that waits has not failed
    assert {pilot.act(seen()) for _ in range(PATIENCE + 2)} == {WAIT}


def test_a_robot_leaves_its_charger_where_charging_gets_slow() -> None:
    full = [hall(battery=Battery(200, knee=knee)).full for knee in (1.0, 0.8, 0.5)]
    assert full == pytest.approx([NEARLY_FULL * 200, 160, ENOUGH * 200])
