"""The baseline agents: random and reflex."""

import pytest

from agents.learning.baselines import RandomAgent, ReflexAgent
from warehouse_core import WarehouseEnv, record_episode
from warehouse_core.records.failure_modes import OSCILLATION, diagnose


def test_the_random_agent_takes_every_action_and_depends_only_on_its_seed() -> None:
    agent = RandomAgent(3)
    first, again = (record_episode(WarehouseEnv(), agent, seed=1).actions for _ in range(2))
    assert first == again
    assert set(first) == set(WarehouseEnv.ACTIONS)
    assert record_episode(WarehouseEnv(), RandomAgent(4), seed=1).actions != first


def test_the_reflex_agent_delivers_if_there_is_no_obstacle() -> None:
    env = WarehouseEnv(["..P...D"], (0, 0))
    episode = record_episode(env, ReflexAgent(), randomize=False)
    assert episode.actions == ["E", "E", "PICK", "E", "E", "E", "E", "DROP"]


def test_the_reflex_agent_oscillates_in_front_of_an_obstacle() -> None:
    trap = ["#######", "#..#..#", "#..#.P#", "#..#..#", "#.....#", "#D....#", "#######"]
    episode = record_episode(WarehouseEnv(trap, (2, 2)), ReflexAgent(), randomize=False)
    assert diagnose(episode).mode == OSCILLATION
    assert len(set(episode.cells)) == 2


@pytest.mark.parametrize("grid", [[".."], ["#.#"]])
def test_the_reflex_agent_waits_without_a_goal(grid: list[str]) -> None:
    agent = ReflexAgent()
    agent.reset()
    assert agent.act(WarehouseEnv(grid, None).reset()) == "WAIT"
