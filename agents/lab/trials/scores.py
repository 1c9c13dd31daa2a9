"""Scores of an agent or a fleet over several episodes, with 95% intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
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

__all__ = ["Scores"]


@dataclass(frozen=True)
class Scores:
    """The scores of an agent that controls a lone robot.

    Steps, seconds and joules per delivery are sums over all episodes divided by the number of
    deliveries. Means over the deliveries alone would favour an agent that delivers only nearby
    items.

    Args:
        rows: row of each episode.
        nodes: number of nodes that the agent expanded in each episode, 0 without a search.

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
        """Whether each episode ended with the delivery, ``[N]``."""
        return np.array([row.mode == DELIVERED for row in self.rows], np.bool_)

    @property
    def lengths(self) -> NDArray[np.int64]:
        """Number of steps in each episode, ``[N]``."""
        return np.array([row.steps for row in self.rows], np.int64)

    @property
    def summary(self) -> str:
        """Share of episodes with a delivery, for a progress line."""
        return f"{self.delivered.mean():.0%}"

    @property
    def success(self) -> Interval:
        """Share of episodes that ended with the delivery."""
        return share_interval(int(self.delivered.sum()), len(self.rows))

    def per_delivery(self, name: str) -> Interval | None:
        """Return the sum of a field of all rows, such as ``"steps"``, divided by the deliveries.

        Return ``None`` without a delivery.
        """
        return ratio_interval(np.array([getattr(row, name) for row in self.rows]), self.delivered)

    @property
    def ratio(self) -> Interval | None:
        """Mean ratio, at least 1, of the steps of a delivery to the fewest possible steps."""
        ratios = [
            row.steps / row.needed for row in self.rows if row.needed and row.mode == DELIVERED
        ]
        return mean_interval(np.array(ratios))

    @property
    def expanded(self) -> Interval | None:
        """Mean number of nodes expanded in an episode."""
        return mean_interval(np.array(self.nodes, dtype=float))


@dataclass(frozen=True)
class FleetScores:
    """The scores of a fleet, given the rows of its episodes and its number of robots."""

    rows: Sequence[FleetRow]
    robots: int

    @property
    def summary(self) -> str:
        """Deliveries per hour, for a progress line."""
        return f"{self.per_hour.estimate:.0f} per hour"

    @property
    def per_hour(self) -> Interval:
        """Mean number of deliveries per hour over the episodes."""
        return _mean(math.nan if row.per_hour is None else row.per_hour for row in self.rows)

    @property
    def blocked(self) -> Interval:
        """Mean share of the robots' steps in which another robot blocked them."""
        return _mean(row.blocked_by_robot / (row.steps * self.robots) for row in self.rows)


def _mean(values: Iterable[float]) -> Interval:
    """Return the mean of at least one value."""
    return mean_interval(np.array(list(values))) or Interval(math.nan)


class Measure(NamedTuple):
    """A measure by which agents are compared.

    Attributes:
        column: Name of its column in a table.
        title: Title of its panel in a figure.
        of: Function that returns the measure of some scores.
        is_log: True if its axis is logarithmic, because agents differ by orders of magnitude.
    """

    column: str
    title: str
    of: Callable[[Scores], Interval | None]
    is_log: bool = False


def _per_delivery(name: str) -> Measure:
    title = f"{name} per delivery"
    return Measure(title, title, lambda scores: scores.per_delivery(name), is_log=True)


MEASURES = (
    Measure("success", "delivered", lambda scores: scores.success),
    _per_delivery("steps"),
    Measure(
        "steps / fewest\n(deliveries)", "steps / fewest possible steps",
        lambda scores: scores.ratio, is_log=True,
    ),
    Measure("expanded", "nodes expanded per episode", lambda scores: scores.expanded),
    _per_delivery("seconds"),
    _per_delivery("joules"),
)  # fmt: skip

GRID_MEASURES = MEASURES[:4]
"""Measures on the grid, which has no seconds and no joules of its own."""

EXPLANATION = (
    "Steps, seconds and joules per delivery are sums over all episodes, including failures, "
    "divided by the number of deliveries. The ratio of steps to the fewest possible steps is a "
    f"mean over the deliveries alone. Ranges are {CONFIDENCE:.0%} intervals. Means and ratios of "
    f"fewer than {MIN_VALUES} deliveries or episodes have no intervals."
)
"""Explanation of the measures below a table or a figure."""
