"""What the rows of an agent's episodes come to, with 95% intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
from agents.lab.trials.rows import FleetRow, Row
from warehouse_core.records.episode import DELIVERED

__all__ = ["FleetScores", "Scores"]


@dataclass(frozen=True)
class Scores:
    """The episodes of an agent of a lone robot, and what they come to.

    Steps, seconds and joules a delivery are sums over all episodes divided by the deliveries. Means
    over the deliveries alone would favour an agent that delivers only what is near. ``nodes`` are
    those that the agent expanded in each episode; 0 without a search.

    Example:
        >>> from agents import GreedyAgent
        >>> from agents.lab.trials.task import Task
        >>> scores = Task().evaluate(GreedyAgent, range(20))
        >>> scores.success.estimate, round(scores.success.low, 2), round(scores.success.high, 2)
        (0.75, 0.53, 0.89)
    """

    rows: Sequence[Row]
    nodes: Sequence[int]

    @property
    def delivered(self) -> NDArray[np.bool_]:
        """``[N]`` whether each episode ended with the delivery."""
        return np.array([row.mode == DELIVERED for row in self.rows], np.bool_)

    @property
    def lengths(self) -> NDArray[np.int64]:
        """``[N]`` the steps of each episode."""
        return np.array([row.steps for row in self.rows], np.int64)

    @property
    def summary(self) -> str:
        """The share of deliveries, for a line of progress."""
        return f"{self.delivered.mean():.0%}"

    @property
    def success(self) -> Interval:
        """The share of episodes that ended with the delivery."""
        return share_interval(int(self.delivered.sum()), len(self.rows))

    @property
    def steps(self) -> Interval | None:
        """The steps of all episodes divided by the deliveries; ``None`` without a delivery."""
        return ratio_interval(self.lengths, self.delivered)

    @property
    def ratio(self) -> Interval | None:
        """The mean, over deliveries, of their steps divided by the fewest; at least 1."""
        ratios = [
            row.steps / row.needed for row in self.rows if row.needed and row.mode == DELIVERED
        ]
        return mean_interval(np.array(ratios))

    @property
    def seconds(self) -> Interval | None:
        """The simulated time of all episodes divided by the deliveries, in s."""
        return ratio_interval(np.array([row.seconds for row in self.rows]), self.delivered)

    @property
    def joules(self) -> Interval | None:
        """The energy of all episodes divided by the deliveries, in J."""
        return ratio_interval(np.array([row.joules for row in self.rows]), self.delivered)

    @property
    def expanded(self) -> Interval | None:
        """The nodes expanded in an episode."""
        return mean_interval(np.array(self.nodes, dtype=float))


@dataclass(frozen=True)
class FleetScores:
    """The episodes of a fleet, and what they come to.

    Example:
        >>> from agents.lab.trials.task import FleetTask
        >>> from agents.registry import make_team
        >>> task = FleetTask(robots=2, max_steps=50)
        >>> scores = task.evaluate_fleet(lambda seed: make_team("greedy", 2, seed), range(3))
        >>> scores.per_hour.estimate
        144.0
    """

    rows: Sequence[FleetRow]
    robots: int

    @property
    def summary(self) -> str:
        """The deliveries in an hour, for a line of progress."""
        return f"{self.per_hour.estimate:.0f} an hour"

    @property
    def per_hour(self) -> Interval:
        """The items delivered in an hour, a mean over the episodes."""
        return _mean([math.nan if row.per_hour is None else row.per_hour for row in self.rows])

    @property
    def blocked(self) -> Interval:
        """The share of the robots' steps in which others blocked them, a mean over the episodes."""
        return _mean([row.blocked_by_robot / (row.steps * self.robots) for row in self.rows])


def _mean(values: Sequence[float]) -> Interval:
    """Return the mean of at least one value."""
    return mean_interval(np.array(values)) or Interval(math.nan)


class Measure(NamedTuple):
    """A number by which agents are compared: its name in a table, and above a chart.

    Its axis may be logarithmic, because agents differ by orders of magnitude.
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
"""Definition of the measures, for a reader of a table or a figure."""
