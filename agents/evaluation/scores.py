"""How several agents do over the same seeds: what they deliver, what it takes, what they search."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.evaluation.interval import Interval, mean_interval, share_interval
from agents.run_episode import make_env
from agents.search.agents import ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Agent, Layout, record_episode
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import diagnose

MakeAgent = Callable[[int, Layout], Agent]
"""Makes an agent for a seed and the walls of a layout."""

CONTENDERS: dict[str, MakeAgent] = {
    "greedy": lambda seed, layout: GreedyAgent(seed),
    "greedy without escape": lambda seed, layout: GreedyAgent(seed, escape_steps=0),
    "exploring": lambda seed, layout: ExploringAgent(),
    "uniform-cost": lambda seed, layout: SearchAgent(layout, "ucs"),
    "A*": lambda seed, layout: SearchAgent(layout, "astar"),
}
"""The chapter's agent, and what search puts in its place."""


class Task(NamedTuple):
    """Where the agents are compared."""

    layout: Layout
    backend: str
    battery: int
    max_steps: int


class Run(NamedTuple):
    """One episode of an agent.

    Attributes:
        delivered: whether the item was.
        steps: its length.
        needed: the fewest steps there are; NaN where no way leads there.
        seconds: of simulated time.
        joules: of energy.
        expanded: nodes that its agent has expanded; 0 for one that does not search.
    """

    delivered: bool
    steps: int
    needed: float
    seconds: float
    joules: float
    expanded: int


@dataclass(frozen=True)
class Scores:
    """What the episodes of an agent come to; all but success and expansions are of deliveries."""

    runs: Sequence[Run]

    @property
    def success(self) -> Interval:
        """The share that was delivered."""
        return share_interval(sum(run.delivered for run in self.runs), len(self.runs))

    @property
    def steps(self) -> Interval | None:
        """The steps of a delivery."""
        return self._mean(lambda run: run.steps)

    @property
    def ratio(self) -> Interval | None:
        """The steps of a delivery over the fewest that there are: 1 is as short as can be."""
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
    """Something that agents are compared by.

    Attributes:
        column: its name in a table.
        title: what it is, above a chart.
        of: the measure.
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


def run_agent(make: MakeAgent, task: Task, seed: int) -> Run:
    """Run one episode, from a random start."""
    env = make_env(task.layout, task.backend, task.battery, task.max_steps)
    agent = make(seed, task.layout)
    try:
        episode = record_episode(env, agent, seed=seed)
    finally:
        env.close()
    needed = diagnose(episode).needed
    return Run(
        episode.outcome == DELIVERED,
        episode.steps,
        float("nan") if needed is None else needed,
        episode.seconds,
        episode.joules,
        getattr(agent, "expanded", 0),
    )
