"""The simple reflex agent, whose rules use the current observation only.

Source: Russell and Norvig, 4th ed., section 2.4.2.
"""

from __future__ import annotations

import random

from agents.warehouse_agent_greedy import distance, distance_after, goal_of, open_moves
from warehouse_core.arguments import real_number, seed_number
from warehouse_core.task.state import Observation


class ReflexAgent:
    """A simple reflex agent, which remembers nothing and applies rules to what it observes now.

    Args:
        seed: seed of its random stream, restarted at each ``reset``; ``None`` uses a random seed.
        chance: probability, 0 to 1, of a random open move in a step. Random moves get it out of
            loops.

    Example:
        >>> from agents import ReflexAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> record_episode(WarehouseEnv(), ReflexAgent(), seed=12).outcome
        'battery depleted'
    """

    def __init__(self, seed: int | None = None, chance: float = 0.0) -> None:
        self.seed, self.chance = seed_number(seed), real_number("chance", chance, 0.0, 1.0)
        self.reset()

    def reset(self) -> None:
        """Restart the random stream."""
        self._random, self.reason = random.Random(self.seed), ""

    def act(self, observation: Observation) -> str:
        """Return the action of the first rule that applies, and set ``reason`` to the rule."""
        here, goal = observation["robot_pos"], goal_of(observation)
        moves = open_moves(observation["local_grid"])
        if here == goal:
            self.reason = "at the goal"
            return "DROP" if observation["has_item"] else "PICK"
        if goal is None or not moves:
            self.reason = "nowhere to go"
            return "WAIT"
        if self.chance and self._random.random() < self.chance:
            self.reason = "random move"
            return self._random.choice(moves)
        closer = [move for move in moves if distance_after(move, here, goal) < distance(here, goal)]
        self.reason = "closer" if closer else "no move gets closer"
        return (closer or moves)[0]
