"""The answers of a report about fleets: for each parameter that differs its question.

Sentences begin in lower case and have no full stop.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from agents.lab.evaluation.interval import Interval, mean_interval
from agents.lab.evaluation.wording import mean, percent, share
from agents.lab.experiments.parameters import FLEET, shown
from agents.lab.reports.analysis import statements, verdicts
from agents.lab.reports.analysis.answers import (
    APART,
    HARDEST_FIRST,
    MAX_DESCRIBED,
    Answer,
    answers_of,
    is_trend,
    line_of,
    lone_points,
)
from agents.lab.reports.analysis.design import Design, Factor, Series, described
from agents.lab.reports.analysis.results import Experiment, Shifts
from agents.lab.reports.analysis.statements import MIN_CHANGE, Point
from agents.lab.reports.analysis.verdicts import Place
from warehouse_core.wording import counted, listed

Line = Sequence[Point[Shifts]]

PAIRS = """
SELECT a.per_hour - b.per_hour FROM shifts a JOIN shifts b ON b.seed = a.seed
WHERE a.case_id = ? AND b.case_id = ? AND a.per_hour IS NOT NULL AND b.per_hour IS NOT NULL
"""


def fleet_answers(experiment: Experiment[Shifts], design: Design) -> tuple[Answer, ...]:
    """Return an answer for each factor, or one about all episodes if nothing differs."""

    def told(factor: Factor, series: Sequence[Series]) -> Iterator[str]:
        return _sentences(experiment, factor, series)

    return answers_of(design, told, _apart(experiment, design))


def _apart(experiment: Experiment[Shifts], design: Design) -> Iterator[str]:
    """Describe cases none of which can be compared with another."""
    points = list(lone_points(experiment, design))
    yield APART if len(points) > 1 else f"{_rate(points[0])} are delivered"
    for point in points:
        name = f" with {point.name}" if point.name else ""
        yield (
            f"{_rate(point)} are delivered{name} over {counted(point.results.episodes, 'episode')}"
        )
        yield from _measures([point])


def _sentences(
    experiment: Experiment[Shifts], factor: Factor, series: Sequence[Series]
) -> Iterator[str]:
    main, *others = series
    line = line_of(experiment, factor, main)
    where = f"with {described(main.others)}, " if described(main.others) else ""
    is_hardest = factor.name == HARDEST_FIRST
    ranked = sorted(line, key=_items, reverse=not is_hardest)
    most = "fewest" if is_hardest else "most"
    yield where + _verdict(experiment, factor, line if is_trend(factor) else ranked)
    if is_trend(factor):
        yield where + trend(line)
        told: Line = list(dict.fromkeys((line[0], ranked[0], line[-1])))
    else:
        listing = [f"{_rate(point)} with {point.name}" for point in ranked[: statements.MAX_NAMED]]
        yield f"{where}{most} are delivered with {ranked[0].name}: {listed(listing)}"
        told = ranked[:MAX_DESCRIBED]
    yield from statements.numbers(line)
    yield from seed_by_seed(experiment, *ranked[:2])
    yield from _measures(told)
    if others:
        best = [
            (
                (min if is_hardest else max)(line_of(experiment, factor, each), key=_items),
                described(each.others),
            )
            for each in others
        ]
        parts = [
            f"{point.name} with {words}, {_rate(point)}" for point, words in best[:MAX_DESCRIBED]
        ]
        left = len(best) - len(parts)
        more = f", and {counted(left, 'combination')} more" if left else ""
        yield f"elsewhere {most} are delivered with {'; '.join(parts)}{more}"


def _verdict(experiment: Experiment[Shifts], factor: Factor, line: Line) -> str:
    """Return the verdict on a factor.

    Args:
        experiment: the results.
        factor: in question.
        line: its points, in the order of its values or the first of a ranking first.
    """
    places = [
        Place(point.name, point.results.per_hour, mean(Interval(_items(point)), ""))
        for point in line
    ]
    if not is_trend(factor):
        verbs = verdicts.HARDEST if factor.name == HARDEST_FIRST else verdicts.BEST
        return verdicts.ranking(places, verbs, "items an hour")
    words = verdicts.trend("the number of items an hour", places)
    if factor.name != FLEET or not all(place.result.is_known for place in places):
        return words
    best = max(line, key=_items)
    # The largest fleet that may be as good as the best.
    *_, enough = [
        value
        for value, point in zip(factor.values, line, strict=True)
        if point is best or not _is_better(experiment, best, point)
    ]
    if enough == factor.values[-1]:
        return f"{shown(enough)} are not too many: {words}"
    return f"more than {shown(enough)} are too many: {words}"


def _is_better(experiment: Experiment[Shifts], one: Point[Shifts], other: Point[Shifts]) -> bool:
    """Return whether more is delivered, seed by seed, or by the intervals if that is unknown."""
    found = _difference(experiment, one, other)
    if found is None or not found.is_known:
        return other.results.per_hour.high < one.results.per_hour.low
    return found.low > 0


def trend(line: Line) -> str:
    """Describe how deliveries change from the first value to the last."""
    first, last, best = line[0], line[-1], max(line, key=_items)
    if _items(best) - min(map(_items, line)) < MIN_CHANGE * _items(best):
        return f"deliveries are all but the same, {_at(first)} and {_at(last)}"
    falls = last.results.per_hour.high < best.results.per_hour.low
    parts = []
    if best is not first:
        parts.append(f"rise from {_at(first)} to {_at(best)}")
    if best is not last:
        is_known = last.results.per_hour.is_known and best.results.per_hour.is_known
        verb = "fall to" if falls else "are about the same," if is_known else "are"
        parts.append(f"{verb} {_at(last)}" if parts else f"fall from {_at(first)} to {_at(last)}")
    words = f"deliveries {', and '.join(parts)}"
    near = [each for each in line if each.results.per_hour.high >= best.results.per_hour.low]
    if near and near[0] not in (first, best):
        words += f"; the intervals allow as many {_at(near[0])}"
    return words


def seed_by_seed(
    experiment: Experiment[Shifts], one: Point[Shifts], other: Point[Shifts]
) -> Iterator[str]:
    """Describe how the deliveries of two cases differ on the seeds that both have."""
    found = _difference(experiment, one, other)
    if found is None:
        yield f"{one.name} and {other.name} share no seed, so they are not compared seed by seed"
    elif found.is_known and found.estimate:
        size = Interval(abs(found.estimate), *sorted((abs(found.low), abs(found.high))))
        more = "more" if found.estimate > 0 else "fewer"
        words = (
            "a difference that chance explains"
            if found.low <= 0 <= found.high
            else f"{mean(size, '')} {more} an hour"
        )
        yield f"seed by seed, {one.name} against {other.name}: {words}"


def _difference(
    experiment: Experiment[Shifts], one: Point[Shifts], other: Point[Shifts]
) -> Interval | None:
    """Return how many items an hour more are delivered, ``None`` without a common seed."""
    rows = experiment.store.query(PAIRS, one.case_id, other.case_id)
    return mean_interval(np.fromiter((value for (value,) in rows), dtype=float))


def _measures(line: Line) -> Iterator[str]:
    """Give punctuality, energy, traffic and modes with each value."""
    yield from _each(line, "on_time", share, "the share on time is")
    yield from _each(line, "energy", lambda found: mean(found, "kJ"), "a delivery costs")
    yield from _each(
        line,
        "blocked",
        lambda found: percent(found.estimate),
        "the share of moves that other robots block is",
    )
    for point in line:
        modes = Counter(point.results.modes)
        parts = [f"{percent(n / modes.total())} {mode}" for mode, n in modes.most_common()]
        name = f" with {point.name}" if point.name else ""
        yield f"the episodes{name} are {listed(parts)}"


def _each(line: Line, measure: str, words: Callable[[Interval], str], about: str) -> Iterator[str]:
    parts = []
    for point in line:
        found: Interval | None = getattr(point.results, measure)
        if found is not None:
            parts.append(words(found) + (f" with {point.name}" if point.name else ""))
    if parts:
        yield f"{about} {listed(parts)}"


def _items(point: Point[Shifts]) -> float:
    return point.results.per_hour.estimate


def _rate(point: Point[Shifts]) -> str:
    return mean(point.results.per_hour, "an hour")


def _at(point: Point[Shifts]) -> str:
    return f"{_rate(point)} at {point.name}"
