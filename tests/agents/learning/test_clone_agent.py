import copy
from pathlib import Path

import numpy as np
import pytest
from helpers.networks import random_moves

from agents.errors import AgentError
from agents.learning.clone_agent import CloneAgent
from agents.learning.map_memory import MapMemory
from agents.registry import make_agent
from warehouse_core import BatchEnv, Layout, WarehouseEnv, random_layout, record_episode
from warehouse_core.world.actions import ACTIONS

FLOOR = random_layout(8, 9, 0.2, seed=1)


def test_an_agent_does_what_a_batch_of_its_network_does() -> None:
    network = random_moves(5)
    batch, memory = (
        BatchEnv(1, FLOOR, randomize=False, autoreset_mode="Disabled"),
        MapMemory(1, 2, 3),
    )
    arrays, info = batch.reset(seed=12)
    expected, ended = [], False
    while not ended:
        scores, masks = network.scores(memory.look(arrays))[0], info["action_mask"][0]
        action = int(np.where(memory.is_open[0], scores, -np.inf).argmax())
        action = next((special for special in (5, 6) if masks[special]), action)
        expected.append(ACTIONS[action])
        arrays, _, terminated, truncated, info = batch.step([action])
        ended = bool(terminated[0] or truncated[0])
    episode = record_episode(WarehouseEnv(FLOOR), CloneAgent(network), randomize=False)
    assert list(episode.actions) == expected
    assert episode.reasons[0].endswith("% sure")


def test_a_memory_belongs_to_an_episode_and_to_an_agent() -> None:
    agent = CloneAgent(random_moves(5))
    env = WarehouseEnv()
    first = record_episode(env, agent, seed=12)
    assert record_episode(env, agent, seed=12).actions == first.actions
    observation = env.reset(seed=3)
    agent.reset()
    agent.act(observation)
    other = copy.deepcopy(agent)
    assert [agent.act(observation) for _ in range(3)] == [other.act(observation) for _ in range(3)]


def test_there_may_be_nowhere_to_go() -> None:
    agent = CloneAgent(random_moves(5))
    assert agent.act(WarehouseEnv(Layout(["...", ".D."])).reset()) == "WAIT"
    assert agent.reason == "nowhere to go"
    walled = WarehouseEnv(Layout(["#####", "#.#P#", "##..#", "#D..#", "#####"]), (1, 1))
    agent.reset()
    assert agent.act(walled.reset()) == "WAIT"


def test_another_view_radius_is_refused(tmp_path: Path) -> None:
    random_moves(1).save(tmp_path / "n.npz")
    agent = make_agent(f"clone:{tmp_path / 'n.npz'}")
    with pytest.raises(AgentError, match="was trained with view radius 2; this robot has 1"):
        agent.act(WarehouseEnv(view_radius=1).reset())
    (tmp_path / "x.npz").write_bytes(b"no network")
    with pytest.raises(AgentError, match="needs what 'warehouse train clone' saves"):
        make_agent(f"clone:{tmp_path / 'x.npz'}")
