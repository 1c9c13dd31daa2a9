"""How well agents do: whole episodes from random starts, the same ones for every agent.

Each start has a seed, so ``warehouse run --seed`` shows any of the episodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.evaluation.interval import Interval, mean_interval, share_interval
from warehouse_core import DEFAULT_LAYOUT, Agent, Layout, WarehouseEnv
from warehouse_core.records.failure_modes import fewest_steps

MakeAgent = Callable[[int], Agent]
"""Returns the agent for the episode with a seed."""


class Task(NamedTuple):
    """What an agent has to do."""

    layout: Layout = DEFAULT_LAYOUT
    battery: int = 200
    max_steps: int = 200
    backend: str = "grid"

    def make_env(self) -> WarehouseEnv:
        """Return an environment for the task."""
        return WarehouseEnv(self.layout, None, self.max_steps, self.battery, backend=self.backend)


class Run(NamedTuple):
    """The outcome of one episode.

    Attributes:
        delivered: whether the item was delivered.
        steps: the length of the episode.
        needed: the fewest steps of a delivery; NaN where no path leads there.
        seconds: simulated time.
        joules: energy.
        expanded: nodes that the agent expanded; 0 for an agent that does not search.
    """

    delivered: bool
    steps: int
    needed: float
    seconds: float
    joules: float
    expanded: int


@dataclass(frozen=True)
class Scores:
    """The outcomes of an agent's episodes, and their means with 95% intervals.

    The means are over deliveries, except those of ``success`` and ``expanded``.
    """

    runs: Sequence[Run]

    @property
    def delivered(self) -> NDArray[np.bool_]:
        """``[N]`` whether each episode ended with the delivery."""
        return np.array([run.delivered for run in self.runs], np.bool_)

    @property
    def lengths(self) -> NDArray[np.int64]:
        """``[N]`` the steps of each episode."""
        return np.array([run.steps for run in self.runs], np.int64)

    @property
    def success(self) -> Interval:
        """The share of episodes that ended with the delivery."""
        return share_interval(int(self.delivered.sum()), len(self.runs))

    @property
    def steps(self) -> Interval | None:
        """The steps of a delivery."""
        return self._mean(lambda run: run.steps)

    @property
    def ratio(self) -> Interval | None:
        """The steps of a delivery divided by the fewest possible; at least 1."""
        return self._mean(lambda run: run.steps / run.needed)

    @property
    def seconds(self) -> Interval | None:
        """The simulated time of a delivery, in s."""
        return self._mean(lambda run: run.seconds)

    @property
    def joules(self) -> Interval | None:
        """The energy of a delivery, in J."""
        return self._mean(lambda run: run.joules)

    @property
    def expanded(self) -> Interval | None:
        """The nodes expanded in an episode."""
        return mean_interval(np.array([run.expanded for run in self.runs], dtype=float))

    def _mean(self, value: Callable[[Run], float]) -> Interval | None:
        return mean_interval(np.array([value(run) for run in self.runs if run.delivered]))


class Measure(NamedTuple):
    """A number by which agents are compared.

    Attributes:
        column: its name in a table.
        title: its name above a chart.
        of: returns its value.
    """

    column: str
    title: str
    of: Callable[[Scores], Interval | None]


MEASURES = (
    Measure("success", "delivered", lambda scores: scores.success),
    Measure("steps", "steps of a delivery", lambda scores: scores.steps),
    Measure("of the fewest", "steps over the fewest there are", lambda scores: scores.ratio),
    Measure("expanded", "nodes expanded in an episode", lambda scores: scores.expanded),
    Measure("seconds", "seconds of a delivery", lambda scores: scores.seconds),
    Measure("joules", "joules of a delivery", lambda scores: scores.joules),
)


def evaluate(make_agent: MakeAgent, task: Task, seeds: Iterable[int]) -> Scores:
    """Run one whole episode for each seed and return the outcomes."""
    return Scores([_run(make_agent(seed), task, seed) for seed in seeds])


def _run(agent: Agent, task: Task, seed: int) -> Run:
    # Random stations depend on the stations before them, so each episode has its own environment.
    with closing(task.make_env()) as env:
        observation, done, terminated = env.reset(randomize=True, seed=seed), False, False
        [needed] = fewest_steps(env.layout, (env.state.robot_pos, False))
        agent.reset()
        seconds = joules = 0.0
        while not done:
            observation, _, terminated, truncated, _ = env.step(agent.act(observation))
            done = terminated or truncated
            assert env.last_motion is not None, "each step has a motion"
            seconds += env.last_motion.seconds
            joules += env.last_motion.joules
        return Run(
            terminated,
            env.state.steps,
            math.nan if needed is None else needed,
            seconds,
            joules,
            getattr(agent, "expanded", 0),
        )
