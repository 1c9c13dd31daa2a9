"""Agents to compare others with: one acts at random, one by rules on what it observes now."""

from __future__ import annotations

import random

from agents.warehouse_agent_greedy import distance, distance_after, open_moves
from warehouse_core.arguments import seed_number
from warehouse_core.task.state import Observation
from warehouse_core.world.actions import ACTIONS

__all__ = ["RandomAgent", "ReflexAgent"]


class RandomAgent:
    """Takes any of the seven actions, each with the same probability.

    Args:
        seed: seed of its random stream, restarted at each ``reset``; ``None`` uses a random one.

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


class ReflexAgent:
    """A simple reflex agent: the same observation gives the same action, as nothing is remembered.

    At its goal it picks or drops. Elsewhere it takes the first open move that lowers the Manhattan
    distance to the goal, and the first open move of all if there is none.

    Source: Russell and Norvig, 4th ed., section 2.4.2.

    Example:
        >>> from agents.learning.baselines import ReflexAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), ReflexAgent(), seed=12).outcome
        'battery depleted'
    """

    def reset(self) -> None:
        """Do nothing."""

    def act(self, observation: Observation) -> str:
        """Return the action of the first rule that applies."""
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        if here == goal:
            return "DROP" if has_item else "PICK"
        moves = open_moves(observation["local_grid"])
        if goal is None or not moves:
            return "WAIT"
        nearer = [move for move in moves if distance_after(move, here, goal) < distance(here, goal)]
        return (nearer or moves)[0]
