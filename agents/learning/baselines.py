"""A random agent, as a baseline for comparisons."""

from __future__ import annotations

import random

from warehouse_core.arguments import seed_number
from warehouse_core.task.state import Observation
from warehouse_core.world.actions import ACTIONS

__all__ = ["RandomAgent"]


class RandomAgent:
    """An agent that takes any of the seven actions with the same probability.

    Args:
        seed: seed of its random stream, restarted at each ``reset``; ``None`` uses a random seed.

    Example:
        >>> from agents.learning.baselines import RandomAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), RandomAgent(seed=1), seed=12).outcome
        'battery depleted'
    """

    def __init__(self, seed: int | None = None) -> None:
        self.seed = seed_number(seed)
        self.reset()

    def reset(self) -> None:
        """Restart the random stream."""
        self._random = random.Random(self.seed)

    def act(self, observation: Observation) -> str:
        """Return a random action."""
        return self._random.choice(ACTIONS)
