"""How well the robots of a fleet do, each directed by an agent of its own."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.evaluation.interval import Interval, mean_interval
from agents.evaluation.scores import MakeAgent
from warehouse_core import DEFAULT_LAYOUT, FleetEnv, Layout
from warehouse_core.fleet import FleetBatch, FleetMeasures
from warehouse_core.vector.rows import SAME_STEP


@dataclass(frozen=True)
class FleetScores:
    """The measures of the episodes of ``robots`` robots, and what they come to.

    Intervals are of 95%.
    """

    runs: Sequence[FleetMeasures]
    robots: int

    @property
    def summary(self) -> str:
        """The deliveries in an hour, for a line of progress."""
        return f"{np.mean([run.per_hour for run in self.runs]):.0f} an hour"

    @property
    def per_hour(self) -> Interval:
        """The items delivered in an hour, a mean over the episodes."""
        return _mean([run.per_hour for run in self.runs])

    @property
    def blocked(self) -> Interval:
        """The share of the robots' steps in which others blocked them, a mean over the episodes."""
        return _mean([run.blocked_by_robot / (run.steps * self.robots) for run in self.runs])


class FleetTask(NamedTuple):
    """What the robots of a fleet have to do.

    Attributes:
        layout: with pickups and dropoffs.
        robots: number of them.
        orders: mean number released in a step.
        battery: units of a full battery.
        max_steps: of an episode.
    """

    layout: Layout = DEFAULT_LAYOUT
    robots: int = 4
    orders: float = 0.2
    battery: int = 200
    max_steps: int = 200

    @property
    def seed_stride(self) -> int:
        """10: an episode has many deliveries, so that every tenth seed is enough."""
        return 10

    def make_env(self) -> FleetEnv:
        """Return a fleet for the task."""
        return FleetEnv(
            self.layout,
            self.robots,
            orders=self.orders,
            battery=self.battery,
            max_steps=self.max_steps,
        )

    def make_batch(self, rows: int) -> FleetBatch:
        """Return a batch for training, of at most so many robots and at least one fleet."""
        return FleetBatch(
            max(rows // self.robots, 1),
            self.layout,
            self.robots,
            orders=self.orders,
            battery=self.battery,
            max_steps=self.max_steps,
            autoreset_mode=SAME_STEP,
        )

    def evaluate(self, make_agent: MakeAgent, seeds: Iterable[int]) -> FleetScores:
        """Run one whole episode for each seed, with an agent for each robot."""
        with closing(self.make_env()) as env:
            return FleetScores([_run(env, make_agent, seed) for seed in seeds], self.robots)


def _mean(values: Sequence[float]) -> Interval:
    """Return the mean of at least one value."""
    return mean_interval(np.array(values)) or Interval(math.nan)


def _run(env: FleetEnv, make_agent: MakeAgent, seed: int) -> FleetMeasures:
    robots = env.settings.robots
    env.reset(seed)
    agents = [make_agent(seed * robots + robot) for robot in range(robots)]
    for agent in agents:
        agent.reset()
    ended = False
    while not ended:
        seen = zip(agents, env.observations(), strict=True)
        actions = [agent.act(observation) for agent, observation in seen]
        *_, terminated, truncated, _ = env.step(actions)
        ended = bool((terminated | truncated).all())
    return env.measures
