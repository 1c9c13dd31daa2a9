"""The agent that acts at random."""

from agents.learning.baselines import RandomAgent
from warehouse_core import WarehouseEnv, record_episode


def test_the_random_agent_takes_every_action_and_depends_only_on_its_seed() -> None:
    agent = RandomAgent(3)
    first, again = (record_episode(WarehouseEnv(), agent, seed=1).actions for _ in range(2))
    assert first == again
    assert set(first) == set(WarehouseEnv.ACTIONS)
    assert record_episode(WarehouseEnv(), RandomAgent(4), seed=1).actions != first
