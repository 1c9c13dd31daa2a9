"""What the episodes of an agent are judged by, and how many points that is worth."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

from agents.lab.grading.cases import CALL, EPISODE, GradedCase, Run
from agents.lab.grading.sandbox import SLOW
from agents.lab.trials.wording import percent
from warehouse_core.records.episode import DELIVERED
from warehouse_core.wording import counted, listed

__all__ = ["Criterion"]

VISIBLE = "visible"
VISIBILITIES = (VISIBLE, "after_due_date", "after_published", "hidden")
"""Times at which Gradescope shows a criterion to students; pages show what is visible."""

MAX_USELESS = 10
"""Useless actions that an agent may take in an episode without a way."""

WITH_WAY, WITHOUT = "with a way to deliver", "without a way to deliver"

Runs = Sequence[Run]


class GradedMeasure(NamedTuple):
    """A number by which an agent is judged.

    Attributes:
        asked: says what is asked, with ``{}`` for the number as it is ``shown``.
        badness: the worst episode is the first that has the largest.
        seen: says what was seen, beside the number.
        counted: the episodes that count, ``WITH_WAY``, ``WITHOUT`` or "" for all.
        is_secret: the number is not told, because it is different each time; such a measure gives
            all points or none.
        unit: ``EPISODE`` or ``CALL``, what it judges.
    """

    asked: str
    shown: Callable[[float], str]
    value: Callable[[Runs], float]
    badness: Callable[[Run], float]
    seen: Callable[[Runs], str]
    counted: str = ""
    more_is_better: bool = True
    is_secret: bool = False
    unit: str = EPISODE

    def is_better(self, value: float, other: float, *, or_equal: bool = False) -> bool:
        """Return whether a number is better than another."""
        if value == other:
            return or_equal
        return (value > other) is self.more_is_better

    def counts(self, run: Run) -> bool:
        """Return whether an episode counts."""
        return not self.counted or (self.counted == WITHOUT) is (run.needed is None)


class Criterion(NamedTuple):
    """A measure of some episodes, and its points.

    Attributes:
        kind: the name of its measure.
        cases: names of the cases whose episodes it judges.
        full: the number that gives all points.
        zero: the number that gives none; between the two they grow evenly. If it is ``full``,
            there are all points or none.
        needs: an earlier criterion; without any points there are none here either.
        visibility: time at which students see it, one of ``VISIBILITIES``.

    Example:
        >>> from agents.lab.grading.criteria import Criterion
        >>> criterion = Criterion("delivers", 10, "delivered", ("hidden",), full=1.0, zero=0.5)
        >>> criterion.points_for(0.75), criterion.points_for(0.2)
        (5.0, 0.0)
    """

    name: str
    points: float
    kind: str
    cases: tuple[str, ...]
    full: float
    zero: float
    needs: str | None = None
    visibility: str = "visible"

    @property
    def measure(self) -> GradedMeasure:
        """The measure by which its episodes are judged."""
        return MEASURES[self.kind]

    @property
    def asked(self) -> str:
        """The demand for all points, and the number that gives none."""
        measure = self.measure
        asked = measure.asked.format(measure.shown(self.full))
        return (
            asked if self.zero == self.full else f"{asked}; no points at {measure.shown(self.zero)}"
        )

    def points_for(self, value: float) -> float:
        """Return the points for a number, rounded to hundredths."""
        if not self.measure.is_better(self.full, value):
            return self.points
        if not self.measure.is_better(value, self.zero):
            return 0.0
        # Not up to the full points, which only the full number gives.
        share = (value - self.zero) / (self.full - self.zero)
        return min(round(share * self.points, 2), max(self.points - 0.01, 0.0))


def _steps(runs: Runs) -> int:
    """Return the steps of episodes; one without a delivery has as many as it may have."""
    return sum(run.charged_steps for run in runs)


def _slowness(run: Run) -> float:
    """Return how many times the fewest steps an episode takes; failures are slowest of all."""
    return (math.inf if run.failure else run.charged_steps) / (run.needed or 1)


def outcomes(runs: Runs) -> str:
    """Return how often each outcome occurs, the most frequent first."""
    counts = Counter(run.outcome for run in runs)
    rows = sorted(counts.items(), key=lambda row: (row[0] != DELIVERED, -row[1], row[0]))
    return listed(f"{count} {mode}" for mode, count in rows)


def _useless(runs: Runs) -> str:
    most = max(run.useless for run in runs)
    failed = sum(bool(run.failure) for run in runs)
    return f"{counted(failed, 'failure')}, at most {counted(most, 'useless action')} in an episode"


def _invalid(runs: Runs) -> str:
    failed = sum(bool(run.failure) for run in runs)
    unknown = sum(run.unknown for run in runs)
    return f"{counted(failed, 'failure')}, {counted(unknown, 'unknown action')}"


def _times(value: float) -> str:
    return f"{value:.2f} times"


def _greedy_ratio(runs: Runs) -> float:
    greedy = (run.case.greedy_steps(run.seed) for run in runs if isinstance(run.case, GradedCase))
    return sum(greedy) / _steps(runs)


def _slowest(run: Run) -> float:
    """Return the seconds of the slowest answer; none within the limit is slower than any."""
    return math.inf if run.failure and run.failure.kind == SLOW else run.slowest


def _in_time(runs: Runs) -> str:
    """Return what may be told: no times, which are different each time."""
    late = sum(math.isinf(_slowest(run)) for run in runs)
    return f"{late or 'none'} too slow"


def _share_of(
    asked: str,
    is_good: Callable[[Run], bool],
    badness: Callable[[Run], float],
    seen: Callable[[Runs], str],
    counted: str = "",
    unit: str = EPISODE,
) -> GradedMeasure:
    """Return the measure of the share of good runs; the badness of another one is above 0."""
    return GradedMeasure(
        asked, percent, lambda runs: sum(map(is_good, runs)) / len(runs),
        lambda run: 0 if is_good(run) else badness(run), seen, counted, unit=unit,
    )  # fmt: skip


MEASURES = {
    "delivered": _share_of(
        "{} of the episodes end with the delivery",
        lambda run: run.delivered, lambda run: 1 + bool(run.failure), outcomes, WITH_WAY,
    ),
    "steps_of_fewest": GradedMeasure(
        "at most {} the fewest possible steps, an episode without a delivery counted with all",
        _times, lambda runs: _steps(runs) / sum(run.needed or 0 for run in runs),
        _slowness, outcomes, WITH_WAY, more_is_better=False,
    ),
    "greedy_steps": GradedMeasure(
        "the greedy agent takes {} as many steps",
        _times, _greedy_ratio, _slowness, outcomes, WITH_WAY,
    ),
    "calm_without_way": _share_of(
        "in {} of the episodes without a way no failure, and at most "
        f"{MAX_USELESS} useless actions (picks, drops, bumps, unknown ones)",
        lambda run: not run.failure and run.useless <= MAX_USELESS,
        lambda run: run.useless + 1000 * bool(run.failure), _useless, WITHOUT,
    ),
    "protocol": _share_of(
        "in {} of the episodes no failure and no unknown action",
        lambda run: not run.failure and not run.unknown,
        lambda run: run.unknown + 1000 * bool(run.failure), _invalid,
    ),
    "answer_seconds": GradedMeasure(
        "each answer takes less than {}",
        lambda seconds: f"{seconds:g} s", lambda runs: max(map(_slowest, runs)),
        _slowest, _in_time, more_is_better=False, is_secret=True,
    ),
    "flawless": _share_of(
        "{} of the episodes end with the delivery, without a useless action (pick, drop, bump, "
        "unknown one)",
        lambda run: run.delivered and not run.useless,
        lambda run: 1 + run.useless + 1000 * bool(run.failure),
        lambda runs: f"{outcomes(runs)}; {_useless(runs)}", WITH_WAY,
    ),
    "reward": GradedMeasure(
        "a mean reward of at least {}",
        lambda value: f"{value:.2f}", lambda runs: sum(run.reward for run in runs) / len(runs),
        lambda run: 1000 * bool(run.failure) - run.reward, outcomes,
    ),
    "answered": _share_of(
        "{} of the calls give the right answer",
        lambda run: run.delivered, lambda run: 1 + bool(run.failure), outcomes, unit=CALL,
    ),
}  # fmt: skip
