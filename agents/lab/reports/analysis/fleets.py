"""What a report says about fleets: how many items they deliver in an hour, and what that costs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from agents.lab.parameters import FLEET, shown
from agents.lab.reports.analysis.design import described
from agents.lab.reports.analysis.question import (
    MAX_DESCRIBED,
    MAX_NAMED,
    MIN_CHANGE,
    FactorValue,
    Question,
    no_common_seed,
    numbers,
)
from agents.lab.reports.analysis.results import BLOCKED, ENERGY, ON_TIME, ReportedMeasure
from agents.lab.trials.interval import Interval, mean_interval
from agents.lab.trials.wording import mean, percent, share
from warehouse_core.wording import counted, listed

FactorCurve = Sequence[FactorValue]

PAIRS = """
SELECT a.per_hour - b.per_hour FROM shifts a JOIN shifts b ON b.seed = a.seed
WHERE a.case_id = ? AND b.case_id = ? AND a.per_hour IS NOT NULL AND b.per_hour IS NOT NULL
"""


def told(question: Question) -> Iterator[str]:
    """Answer a question: first the verdict, then the sentences that say how it is known."""
    line, ranked = question.line(question.main), question.ranked(question.main)
    most = "fewest" if question.is_hardest else "most"
    yield question.where + _verdict(question, line)
    if question.is_trend:
        yield question.where + trend(line)
        described_points: FactorCurve = list(dict.fromkeys((line[0], ranked[0], line[-1])))
    else:
        listing = [f"{_rate(point)} with {point.name}" for point in ranked[:MAX_NAMED]]
        yield f"{question.where}{most} are delivered with {ranked[0].name}: {listed(listing)}"
        described_points = ranked[:MAX_DESCRIBED]
    yield from numbers(line)
    yield from seed_by_seed(*ranked[:2])
    yield from _measures(described_points)
    if question.others:
        parts = [
            f"{best.name} with {described(each.others)}, {_rate(best)}"
            for each in question.others[:MAX_DESCRIBED]
            for best in question.ranked(each)[:1]
        ]
        left = len(question.others) - len(parts)
        more = f", and {counted(left, 'combination')} more" if left else ""
        yield f"elsewhere {most} are delivered with {'; '.join(parts)}{more}"


def alone(point: FactorValue) -> Iterator[str]:
    """Describe one case: in short, and then by all sentences."""
    yield f"{_rate(point)} are delivered"
    episodes = counted(point.results.episodes, "episode")
    yield f"{_rate(point)} are delivered{point.which} over {episodes}"
    yield from _measures([point])


def _verdict(question: Question, line: FactorCurve) -> str:
    """Return the verdict on a factor, whose points are in the order of its values."""
    words = question.verdict(
        lambda value: mean(Interval(value), ""), "the number of items an hour", "items an hour"
    )
    is_known = all(point.results.main.is_known for point in line)
    if not (question.is_trend and question.factor.name == FLEET and is_known):
        return words
    best = max(line, key=lambda point: point.value)
    # The largest fleet that may be as good as the best.
    *_, (enough, largest) = [
        (value, point)
        for value, point in zip(question.main.cases, line, strict=True)
        if point is best or not _is_better(best, point)
    ]
    if largest is line[-1]:
        return f"{shown(enough)} are not too many: {words}"
    return f"more than {shown(enough)} are too many: {words}"


def _is_better(one: FactorValue, other: FactorValue) -> bool:
    """Return whether more is delivered, seed by seed, or by the intervals if that is unknown."""
    difference = _difference(one, other)
    if difference is None or not difference.is_known:
        return other.results.main.high < one.results.main.low
    return difference.low > 0


def trend(line: FactorCurve) -> str:
    """Describe how deliveries change from the first value to the last."""
    first, last, best = line[0], line[-1], max(line, key=lambda point: point.value)
    if best.value - min(point.value for point in line) < MIN_CHANGE * best.value:
        return f"deliveries are all but the same, {_at(first)} and {_at(last)}"
    falls = last.results.main.high < best.results.main.low
    parts = []
    if best is not first:
        parts.append(f"rise from {_at(first)} to {_at(best)}")
    if best is not last:
        is_known = last.results.main.is_known and best.results.main.is_known
        verb = "fall to" if falls else "are about the same," if is_known else "are"
        parts.append(f"{verb} {_at(last)}" if parts else f"fall from {_at(first)} to {_at(last)}")
    words = f"deliveries {', and '.join(parts)}"
    near = [each for each in line if each.results.main.high >= best.results.main.low]
    if near and near[0] not in (first, best):
        words += f"; the intervals allow as many {_at(near[0])}"
    return words


def seed_by_seed(one: FactorValue, other: FactorValue) -> Iterator[str]:
    """Describe how the deliveries of two cases differ on the seeds that both have."""
    difference = _difference(one, other)
    if difference is None:
        yield no_common_seed(one, other)
    elif difference.is_known and difference.estimate:
        more = "more" if difference.estimate > 0 else "fewer"
        words = (
            "a difference that chance explains"
            if difference.low <= 0 <= difference.high
            else f"{mean(abs(difference), '')} {more} an hour"
        )
        yield f"seed by seed, {one.name} against {other.name}: {words}"


def _difference(one: FactorValue, other: FactorValue) -> Interval | None:
    """Return how many items an hour more are delivered, ``None`` without a common seed."""
    rows = one.results.store.query(PAIRS, one.case_id, other.case_id)
    return mean_interval(np.fromiter((value for (value,) in rows), dtype=float))


def _measures(line: FactorCurve) -> Iterator[str]:
    """Give punctuality, energy, traffic and modes with each value."""
    yield from _each(line, ON_TIME, share, "the share on time is")
    yield from _each(line, ENERGY, lambda interval: mean(interval, "kJ"), "a delivery costs")
    yield from _each(
        line, BLOCKED, lambda interval: percent(interval.estimate),
        "the share of moves that other robots block is",
    )  # fmt: skip
    for point in line:
        modes = Counter(point.results.modes)
        parts = [f"{percent(n / modes.total())} {mode}" for mode, n in modes.most_common()]
        yield f"the episodes{point.which} are {listed(parts)}"


def _each(
    line: FactorCurve, measure: ReportedMeasure, words: Callable[[Interval], str], about: str
) -> Iterator[str]:
    intervals = [(point, point.results.interval(measure)) for point in line]
    parts = [f"{words(interval)}{point.which}" for point, interval in intervals if interval]
    if parts:
        yield f"{about} {listed(parts)}"


def _rate(point: FactorValue) -> str:
    return mean(point.results.main, "an hour")


def _at(point: FactorValue) -> str:
    return f"{_rate(point)} at {point.name}"
