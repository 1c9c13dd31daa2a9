"""Teams of agents, and the shifts that they work."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from agents.fleet import Team
from agents.registry import make_team
from agents.search.agents import SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import FleetEnv, Layout, Observation, OrderStream
from warehouse_core.errors import EndedError
from warehouse_core.records.recorder import record_fleet_episode, replay_fleet_episode

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


def make_env(robots: int = 3, **settings: object) -> FleetEnv:
    return FleetEnv(ROOM, robots, orders=OrderStream(0.2), max_steps=60, **settings)  # type: ignore[arg-type]


class Fixed:
    """Always does the same."""

    reason = "fixed"

    def reset(self) -> None:
        pass

    def act(self, observation: Observation) -> str:
        return "E"


def test_each_robot_is_directed_by_its_own_agent_and_has_its_reason() -> None:
    env = make_env(2, starts=[(2, 1), (2, 5)])
    env.reset(seed=1)
    while None in env.order_of:
        env.step(["WAIT", "WAIT"])
    team = Team([Fixed(), GreedyAgent(1)])
    assert team.act(env)[0] == 1
    assert team.reason == ["fixed", "greedy"]
    assert team.robot is None


def test_the_observations_of_all_robots_are_those_of_each() -> None:
    env = make_env()
    with pytest.raises(EndedError, match="observations"):
        env.observations()
    env.reset(seed=1)
    env.step(["E", "N", "PICK"])
    assert env.observations() == [env.observe(robot) for robot in range(3)]


def test_the_same_seed_repeats_a_shift_with_the_same_team_and_a_new_one() -> None:
    env, team = make_env(8), make_team("bfs", 8, 5, ROOM)  # who has no random moves of its own
    first = record_fleet_episode(env, team, seed=2)
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


def test_agents_that_know_the_walls_deliver_the_orders_of_their_robots() -> None:
    env = make_env(2)
    team = make_team("bfs", 2, 1, ROOM)
    assert isinstance(team.agents[0], SearchAgent)
    assert record_fleet_episode(env, team, seed=1).measures.delivered >= 4


class Checked(GreedyAgent):
    """An agent that sees where it acts."""

    places: list[tuple[int, int]]

    def act(self, observation: Observation) -> str:
        self.places = [*getattr(self, "places", []), observation["robot_pos"]]
        return super().act(observation)


def test_agents_of_robots_that_drive_through_act_at_rest() -> None:
    """So each of their moves begins in the cell that they observe, and ends beside it."""
    env = make_env(2, backend="driving")
    agents = [Checked(), Checked()]
    episode = record_fleet_episode(env, Team(agents, seed=1), seed=1)
    assert episode.measures.delivered
    for agent in agents:
        steps = [abs(a - c) + abs(b - d) for (a, b), (c, d) in pairwise(agent.places)]
        assert max(steps) == 1
        assert len(agent.places) < 2 * episode.steps / 3
    assert np.array_equal(episode.cells, replay_fleet_episode(episode).cells)
