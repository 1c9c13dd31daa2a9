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

from agents.lab.trials.interval import (
    CONFIDENCE,
    MIN_VALUES,
    Interval,
    mean_interval,
    ratio_interval,
    share_interval,
)
from agents.lab.trials.random_layouts import RandomLayouts
from warehouse_core import (
    DEFAULT_LAYOUT,
    Agent,
    BatchEnv,
    Cell,
    EpisodeRecorder,
    Layout,
    Observation,
    WarehouseEnv,
)
from warehouse_core.batch.shell.env import SAME_STEP
from warehouse_core.records.failure_modes import fewest_steps

MakeAgent = Callable[[int], Agent]
"""Returns the agent for the episode with a seed."""

Act = Callable[[EpisodeRecorder, Agent, Observation], None]
"""Takes an agent from its reset through an episode, beginning with the first observation."""


class Task(NamedTuple):
    """The task of an agent in each of its episodes.

    Attributes:
        layout: the walls, and the stations if they are not drawn; or random ones, another layout
            for each seed.
        battery: units of a full battery.
        max_steps: steps of an episode.
        backend: name of a motion backend.
        start_pos: the start if it is not drawn; ``None`` for the usual one.
        randomize: parts to draw, see ``WarehouseEnv.reset``.
    """

    layout: Layout | RandomLayouts = DEFAULT_LAYOUT
    battery: int = 200
    max_steps: int = 200
    backend: str = "grid"
    start_pos: Cell | None = None
    randomize: bool | str = True

    def layout_for(self, seed: int) -> Layout:
        """Return the layout of the episode with a seed."""
        return self.layout if isinstance(self.layout, Layout) else self.layout.layout(seed)

    def make_env(self, seed: int = 0) -> WarehouseEnv:
        """Return an environment for the episode with a seed."""
        layout = self.layout_for(seed)
        return WarehouseEnv(
            layout, self.start_pos, self.max_steps, self.battery, backend=self.backend
        )

    @property
    def seed_stride(self) -> int:
        """1: each seed of an evaluation is used."""
        return 1

    def make_batch(self, rows: int) -> BatchEnv:
        """Return a batch for training, on the grid backend, with random stations and starts."""
        return BatchEnv(
            rows,
            self.layout if isinstance(self.layout, Layout) else None,
            pool=None if isinstance(self.layout, Layout) else self.layout.pool(),
            max_steps=self.max_steps,
            battery=self.battery,
            autoreset_mode=SAME_STEP,
        )

    def evaluate(self, make_agent: MakeAgent, seeds: Iterable[int]) -> Scores:
        """Run one whole episode for each seed."""
        return evaluate(make_agent, self, seeds)


class Run(NamedTuple):
    """The outcome of one episode.

    Attributes:
        delivered: the item was delivered.
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
    """The outcomes of an agent's episodes, and what they come to, with 95% intervals.

    Steps, seconds and joules a delivery are sums over all episodes, divided by the deliveries.
    Means over the deliveries alone would favour an agent that delivers only what is near.
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
    def summary(self) -> str:
        """The share of deliveries, for a line of progress."""
        return f"{self.delivered.mean():.0%}"

    @property
    def success(self) -> Interval:
        """The share of episodes that ended with the delivery."""
        return share_interval(int(self.delivered.sum()), len(self.runs))

    @property
    def steps(self) -> Interval | None:
        """The steps of all episodes divided by the deliveries; ``None`` without a delivery."""
        return self._a_delivery(lambda run: run.steps)

    @property
    def ratio(self) -> Interval | None:
        """The mean, over deliveries, of their steps divided by the fewest; at least 1."""
        ratios = [run.steps / run.needed for run in self.runs if run.delivered]
        return mean_interval(np.array(ratios))

    @property
    def seconds(self) -> Interval | None:
        """The simulated time of all episodes divided by the deliveries, in s."""
        return self._a_delivery(lambda run: run.seconds)

    @property
    def joules(self) -> Interval | None:
        """The energy of all episodes divided by the deliveries, in J."""
        return self._a_delivery(lambda run: run.joules)

    @property
    def expanded(self) -> Interval | None:
        """The nodes expanded in an episode."""
        return mean_interval(np.array([run.expanded for run in self.runs], dtype=float))

    def _a_delivery(self, value: Callable[[Run], float]) -> Interval | None:
        return ratio_interval(np.array([value(run) for run in self.runs]), self.delivered)


class Measure(NamedTuple):
    """A number by which agents are compared.

    Attributes:
        column: its name in a table.
        title: its name above a chart.
        of: returns its value.
        is_log: its axis is logarithmic, because agents differ by orders of magnitude.
    """

    column: str
    title: str
    of: Callable[[Scores], Interval | None]
    is_log: bool = False


MEASURES = (
    Measure("success", "delivered", lambda scores: scores.success),
    Measure("steps a delivery", "steps a delivery", lambda scores: scores.steps, is_log=True),
    Measure(
        "of the fewest\n(deliveries)",
        "steps over the fewest, of deliveries",
        lambda scores: scores.ratio,
        is_log=True,
    ),
    Measure("expanded", "nodes expanded an episode", lambda scores: scores.expanded),
    Measure("seconds a delivery", "seconds a delivery", lambda scores: scores.seconds, is_log=True),
    Measure("joules a delivery", "joules a delivery", lambda scores: scores.joules, is_log=True),
)

EXPLANATION = (
    "Steps, seconds and joules a delivery are those of all episodes, failures included, divided "
    "by the deliveries. Steps over the fewest possible: a mean over the deliveries alone. "
    f"Ranges are {CONFIDENCE:.0%} intervals; means and ratios of fewer than {MIN_VALUES} "
    "deliveries or episodes have none."
)
"""Definitions of the measures, for a reader of a table or a figure."""


def evaluate(
    make_agent: MakeAgent, task: Task, seeds: Iterable[int], act: Act = EpisodeRecorder.run
) -> Scores:
    """Run one whole episode for each seed and return the outcomes.

    Args:
        make_agent: makes the agent of each episode.
        task: task of the agent.
        seeds: seeds of the episodes.
        act: takes an agent through an episode, from its reset to the end.
    """
    return Scores([_run(make_agent(seed), task, seed, act) for seed in seeds])


def _run(agent: Agent, task: Task, seed: int, act: Act) -> Run:
    # Random stations depend on the stations before them, so each episode has its own environment.
    with closing(task.make_env(seed)) as env:
        observation = env.reset(task.randomize, seed)
        [needed] = fewest_steps(env.layout, (env.state.robot_pos, False))
        recorder = EpisodeRecorder(env, seed=seed)
        act(recorder, agent, observation)
        episode = recorder.episode
        return Run(
            episode.terminated,
            episode.steps,
            math.nan if needed is None else needed,
            episode.seconds,
            episode.joules,
            getattr(agent, "expanded", 0),
        )
