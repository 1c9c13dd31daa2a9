"""How well the robots of a fleet do, each directed by an agent of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.lab.trials.interval import Interval, mean_interval
from agents.lab.trials.scores import MakeAgent
from warehouse_core import DEFAULT_LAYOUT, Agent, FleetEnv, Layout
from warehouse_core.batch.shell.env import SAME_STEP
from warehouse_core.fleet import FleetBatch, FleetMeasures
from warehouse_core.fleet.env import Actions
from warehouse_core.records.recorder import FleetAgent, FleetRecorder


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
    """The task of a fleet in each of its episodes.

    Attributes:
        layout: layout with pickups and dropoffs.
        robots: number of robots.
        orders: mean number of orders released in a step.
        battery: units of a full battery.
        max_steps: steps of an episode.
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
        """Run one whole episode for each seed, with an agent for each robot, which does as it says.

        Args:
            make_agent: given a seed of its own for each robot.
            seeds: seeds of the episodes.
        """

        def make_all(seed: int) -> FleetAgent:
            first = seed * self.robots
            return _Each([make_agent(first + robot) for robot in range(self.robots)])

        return self.evaluate_fleet(make_all, seeds)

    def evaluate_fleet(
        self, make_agent: Callable[[int], FleetAgent], seeds: Iterable[int]
    ) -> FleetScores:
        """Run one whole episode for each seed, with an agent that directs all robots."""
        with closing(self.make_env()) as env:
            return FleetScores([_run(env, make_agent(seed), seed) for seed in seeds], self.robots)


class _Each:
    """Robots each of which does what its agent says."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        self._agents = agents

    def reset(self) -> None:
        for agent in self._agents:
            agent.reset()

    def act(self, env: FleetEnv) -> Actions:
        seen = zip(self._agents, env.observations(), strict=True)
        return [agent.act(observation) for agent, observation in seen]


def _run(env: FleetEnv, agent: FleetAgent, seed: int) -> FleetMeasures:
    recorder = FleetRecorder(env, seed=seed)
    recorder.run(agent)
    return env.measures


def _mean(values: Sequence[float]) -> Interval:
    """Return the mean of at least one value."""
    return mean_interval(np.array(values)) or Interval(math.nan)
