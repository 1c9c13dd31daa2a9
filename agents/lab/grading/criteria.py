"""Criteria of a rubric: measures of an agent's episodes, and the points for them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

from agents.lab.grading.cases import CALL, EPISODE, GradedCase, Run
from agents.lab.grading.sandbox import SLOW
from agents.lab.trials.interval import percent
from warehouse_core.records.episode import DELIVERED
from warehouse_core.wording import counted, listed

VISIBLE = "visible"
VISIBILITIES = (VISIBLE, "after_due_date", "after_published", "hidden")
"""Times at which Gradescope shows a criterion; pages show criteria that are ``VISIBLE``."""

MAX_USELESS = 10
"""Useless actions that an agent may take in an episode in which it cannot deliver."""

POSSIBLE, IMPOSSIBLE = "in which delivery is possible", "in which delivery is impossible"
"""Episodes that a measure counts, in words."""

Runs = Sequence[Run]


class GradedMeasure(NamedTuple):
    """A number by which an agent is judged.

    Attributes:
        asked: requirement in words, with ``{}`` in place of the number.
        shown: function that formats the number.
        value: function that computes the number from runs.
        badness: function by which the worst run is the first one with the largest result.
        seen: function that describes the runs in words, in addition to the number.
        counted: episodes that count: ``POSSIBLE``, ``IMPOSSIBLE``, or "" for all.
        more_is_better: true if larger numbers are better.
        is_secret: the number is not shown, because it differs each time. Such a measure gives all
            points or none.
        unit: unit of the cases that it judges, ``EPISODE`` or ``CALL``.
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

    def is_better(self, value: float, other: float) -> bool:
        """Return whether a number is better than another."""
        return value > other if self.more_is_better else value < other

    def counts(self, run: Run) -> bool:
        """Return whether an episode counts."""
        return not self.counted or (self.counted == IMPOSSIBLE) is (run.needed is None)


class Criterion(NamedTuple):
    """A measure of the episodes of some cases, and its points.

    Attributes:
        kind: name of the measure.
        cases: names of the cases whose episodes are judged.
        full: number that gives all points.
        zero: number that gives no points. Between the two, points grow linearly. If it equals
            ``full``, there are all points or none.
        needs: name of an earlier criterion. If it has no points, this criterion has none either.
        visibility: time at which students see it, one of ``VISIBILITIES``.
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
        """Measure by which the episodes are judged."""
        return MEASURES[self.kind]

    @property
    def asked(self) -> str:
        """Requirement for all points, and the number that gives none, in words."""
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
        # Rounding must not give all points: only the full number does.
        share = (value - self.zero) / (self.full - self.zero)
        return min(round(share * self.points, 2), max(self.points - 0.01, 0.0))


def _steps(runs: Runs) -> int:
    """Return the steps of episodes; failed episodes count as the step limit."""
    return sum(run.charged_steps for run in runs)


def _slowness(run: Run) -> float:
    """Return the steps of an episode divided by the fewest possible; infinity for a failure."""
    return (math.inf if run.failure else run.charged_steps) / (run.needed or 1)


def outcomes(runs: Runs) -> str:
    """Return how often each outcome occurs, in words: deliveries first, then the most frequent."""
    counts = Counter(run.outcome for run in runs)
    rows = sorted(counts.items(), key=lambda row: (row[0] != DELIVERED, -row[1], row[0]))
    return listed(f"{count} {mode}" for mode, count in rows)


def _failures(runs: Runs, more: str) -> str:
    return f"{counted(sum(bool(run.failure) for run in runs), 'failure')}, {more}"


def _useless(runs: Runs) -> str:
    most = max(run.useless for run in runs)
    return _failures(runs, f"at most {counted(most, 'useless action')} in an episode")


def _invalid(runs: Runs) -> str:
    return _failures(runs, counted(sum(run.unknown for run in runs), "unknown action"))


def _times(value: float) -> str:
    return f"{value:.2f} times"


def _greedy_ratio(runs: Runs) -> float:
    greedy = (run.case.greedy_steps(run.seed) for run in runs if isinstance(run.case, GradedCase))
    return sum(greedy) / _steps(runs)


def _slowest(run: Run) -> float:
    """Return the seconds of the slowest answer; infinity if an answer exceeded the time limit."""
    return math.inf if run.failure and run.failure.kind == SLOW else run.slowest


def _in_time(runs: Runs) -> str:
    """Return how many runs were too slow, in words; their times differ each time."""
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
    """Return a measure of the share of good runs; ``badness`` is above 0 for all others."""
    return GradedMeasure(
        asked, percent, lambda runs: sum(map(is_good, runs)) / len(runs),
        lambda run: 0 if is_good(run) else badness(run), seen, counted, unit=unit,
    )  # fmt: skip


MEASURES = {
    "delivered": _share_of(
        "{} of the episodes end with the delivery",
        lambda run: run.delivered, lambda run: 1 + bool(run.failure), outcomes, POSSIBLE,
    ),
    "steps_of_fewest": GradedMeasure(
        "at most {} the fewest possible steps; failed episodes count as the step limit",
        _times, lambda runs: _steps(runs) / sum(run.needed or 0 for run in runs),
        _slowness, outcomes, POSSIBLE, more_is_better=False,
    ),
    "greedy_steps": GradedMeasure(
        "the greedy agent takes {} as many steps",
        _times, _greedy_ratio, _slowness, outcomes, POSSIBLE,
    ),
    "calm_without_way": _share_of(
        f"no failure and at most {MAX_USELESS} useless actions (picks, drops, bumps, unknown "
        "actions) in {} of the episodes in which delivery is impossible",
        lambda run: not run.failure and run.useless <= MAX_USELESS,
        lambda run: run.useless + 1000 * bool(run.failure), _useless, IMPOSSIBLE,
    ),
    "protocol": _share_of(
        "no failure and no unknown action in {} of the episodes",
        lambda run: not run.failure and not run.unknown,
        lambda run: run.unknown + 1000 * bool(run.failure), _invalid,
    ),
    "answer_seconds": GradedMeasure(
        "each answer takes less than {}",
        lambda seconds: f"{seconds:g} s", lambda runs: max(map(_slowest, runs)),
        _slowest, _in_time, more_is_better=False, is_secret=True,
    ),
    "flawless": _share_of(
        "{} of the episodes end with the delivery and have no useless action (pick, drop, bump, "
        "unknown action)",
        lambda run: run.delivered and not run.useless,
        lambda run: 1 + run.useless + 1000 * bool(run.failure),
        lambda runs: f"{outcomes(runs)}; {_useless(runs)}", POSSIBLE,
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
