"""Q-learning as a training with callbacks that can be resumed."""

from __future__ import annotations

import random
from collections import deque
from functools import partial
from typing import Any

from agents.learning.learner import RECENT_EPISODES, MakeAgent, WatchTraining
from agents.learning.q_learning import QAgent, QTable, learn
from warehouse_core.warehouse_env import WarehouseEnv


class QLearner:
    """Training of a Q-learning table; see ``Learner``.

    Args:
        env: warehouse of all episodes.
        steps: steps of the whole training; the last episode may exceed them.
        seed: seed with which the training can be repeated.
    """

    def __init__(self, env: WarehouseEnv, steps: int, seed: int) -> None:
        self.table = QTable()
        self._env, self._steps, self._taken = env, steps, 0
        self._stream = random.Random(seed)
        self._recent = deque[bool](maxlen=RECENT_EPISODES)

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train to the end, with a callback after each episode; return what makes the agent."""
        make_agent, before = partial(QAgent, self.table), self._taken
        for taken, delivered in learn(self.table, self._env, self._steps - before, self._stream):
            self._taken = before + taken
            self._recent.append(delivered)
            watch(self._taken, sum(self._recent) / len(self._recent), make_agent)
        return make_agent

    def state(self) -> Any:
        """Return the values, the steps taken, the random stream and the latest deliveries."""
        return self.table, self._taken, self._stream, self._recent

    def restore(self, state: Any) -> None:
        """Continue from a state; ``table`` stays the same object."""
        table, self._taken, self._stream, self._recent = state
        self.table.update(table)
