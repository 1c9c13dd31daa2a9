"""What the runs in all worlds come to: a table, and a message."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from agents.lab.commands.gap.trial import Score
from agents.lab.commands.gap.worlds import ALONE, DISTURBED, DRIVING, PLAN, STOPPING, Shocks
from agents.lab.console.table import TextTable
from agents.lab.trials.interval import MIN_VALUES, Interval, mean_interval
from agents.lab.trials.wording import above_interval, percent
from warehouse_core.wording import counted, listed

SeedScores = Mapping[str, Sequence[Score]]
"""The measures of each world, of the same seeds in the same order."""


class GapColumn(NamedTuple):
    """A column of the table: a value of a run, and of the run on the grid with the same seed."""

    title: str
    value: Callable[[Score, Score], float]


OF_THE_PLAN = GapColumn("% of the plan's", lambda score, plan: 100 * ratio(score, plan))

MEASURES = (
    GapColumn("deliveries an hour", lambda score, _: score.per_hour),
    OF_THE_PLAN,
    GapColumn("% on time", lambda score, _: 100 * score.on_time),
    GapColumn("kJ a delivery", lambda score, _: score.joules / 1000),
    GapColumn("last delivery (s)", lambda score, _: score.makespan),
    GapColumn("hits", lambda score, _: score.hits),
)


def ratio(score: Score, plan: Score) -> float:
    """Return deliveries per hour relative to the plan."""
    return score.per_hour / plan.per_hour if plan.per_hour else math.nan


def measured(scores: SeedScores, world: str, measure: GapColumn) -> Interval:
    """Return the mean of a measure of a world, with the interval from the values of the seeds."""
    pairs = zip(scores[world], scores[PLAN], strict=True)
    values = np.array([measure.value(score, plan) for score, plan in pairs])
    return mean_interval(values[~np.isnan(values)]) or Interval(math.nan)


def gap_table(scores: SeedScores, title: str) -> TextTable:
    """Return a table with a row for each world."""
    rows = [
        (world, *(_cell(measured(scores, world, measure)) for measure in MEASURES))
        for world in scores
    ]
    header = ("world", *(measure.title for measure in MEASURES))
    few = len(scores[PLAN]) < MIN_VALUES
    caption = f"Fewer than {MIN_VALUES} episodes have no intervals." if few else ""
    return TextTable(header, rows, title, caption)


def _cell(interval: Interval) -> str:
    """Return a mean, and its interval if it has a width, on two lines."""
    if math.isnan(interval.estimate):  # a share of nothing
        return "none"
    if interval.estimate.is_integer() and (interval.low == interval.high or not interval.is_known):
        return f"{interval.estimate:,.0f}"
    return above_interval(interval)


def message(scores: SeedScores, shocks: Shocks) -> str:
    """Return in a sentence what the worlds bring of what the plan promises."""
    return shares_in_words(
        {world: measured(scores, world, OF_THE_PLAN).estimate / 100 for world in scores}, shocks
    )


def shares_in_words(shares: Mapping[str, float], shocks: Shocks) -> str:
    """Return in a sentence the shares of the plan that the worlds bring."""
    parts = {
        world: "none" if math.isnan(share) else percent(share) for world, share in shares.items()
    }
    what = shocks_in_words(shocks)
    disturbed = f" ({parts[DISTURBED]} with {what})" if what else ""
    return (
        f"Driving through brings {parts[DRIVING]} of what the plan promises{disturbed}, "
        f"{parts[ALONE]} if robots do not meet, stopping in every cell {parts[STOPPING]}"
    )


def shocks_in_words(shocks: Shocks) -> str:
    """Return what happens in the disturbed world, perhaps nothing."""
    words = [f"{shocks.noise:.0%} noise"] if shocks.noise else []
    if shocks.stop:
        stop = "a dead robot" if shocks.stop == math.inf else f"a stop of {shocks.stop:g} s"
        words.append(stop)
    return " and ".join(words)


def losses(scores: SeedScores, orders: int) -> list[str]:
    """Return a warning for each world that lost robots, steps, or some of each run's orders."""
    found = []
    for world, runs in scores.items():
        counts = {
            "order": ("not delivered", sum(orders - run.delivered for run in runs)),
            "robot": ("lost", sum(run.lost for run in runs)),
            "step": ("without a plan", sum(run.late_plans for run in runs)),
        }
        words = [
            f"{counted(number, noun)} {fate}" for noun, (fate, number) in counts.items() if number
        ]
        if words:
            found.append(f"{world}, in {counted(len(runs), 'episode')}: {listed(words)}")
    return found
