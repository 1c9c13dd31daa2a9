"""How well an agent does: whole episodes from random starts, the same ones for every agent.

A start is a seed, so that ``warehouse run --seed`` shows any of the episodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.learning.q_learning import TRAINING_SEEDS
from agents.run_episode import make_env
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout

FIRST_EXAM_SEED = TRAINING_SEEDS
"""Agents that learn from seeds learn from lower ones, and are examined with this and higher."""

RECENT = 1000
"""Episodes of which the share of deliveries is told during training."""

MakeAgent = Callable[[int], Agent]
"""Makes the agent for the episode with a seed."""


class Task(NamedTuple):
    """What an agent has to do."""

    layout: Layout = DEFAULT_LAYOUT
    battery: int = 200
    max_steps: int = 200


class Scores(NamedTuple):
    """How the episodes went.

    Attributes:
        delivered: ``[N]`` whether it ended with the delivery.
        steps: ``[N]`` how long it was.
    """

    delivered: NDArray[np.bool_]
    steps: NDArray[np.int64]

    @property
    def success(self) -> float:
        """The share of episodes that ended with the delivery."""
        return float(self.delivered.mean())

    def steps_to_deliver(self, among: NDArray[np.bool_] | None = None) -> float:
        """Return the mean number of steps of episodes with a delivery, NaN without any.

        Args:
            among: ``[N]``, only these episodes.
        """
        counted = self.delivered if among is None else self.delivered & among
        return float(self.steps[counted].mean()) if counted.any() else float("nan")


def evaluate(make_agent: MakeAgent, task: Task, seeds: Sequence[int]) -> Scores:
    """Run one whole episode for each seed and return how they went."""
    results = [_run(make_agent(seed), task, seed) for seed in seeds]
    delivered, steps = zip(*results, strict=True)
    return Scores(np.array(delivered, np.bool_), np.array(steps, np.int64))


def _run(agent: Agent, task: Task, seed: int) -> tuple[bool, int]:
    """Return whether one episode ended with the delivery, and its steps."""
    # The stations that are drawn depend on those before them, so each start has its own.
    env = make_env(task.layout, "grid", task.battery, task.max_steps)
    observation, done, terminated = env.reset(randomize=True, seed=seed), False, False
    agent.reset()
    while not done:
        observation, _, terminated, truncated, _ = env.step(agent.act(observation))
        done = terminated or truncated
    return terminated, env.state.steps
