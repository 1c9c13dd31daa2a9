"""The sentences of a report: for each setting that differs its question, answered from the data.

A question is answered by the row of cases along its setting that is nearest to the defaults; what
is otherwise in the other rows has a sentence of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from agents.experiments.setting import SETTINGS, Value, shown
from agents.interval import Interval
from agents.reports.comparison import Comparison, compare
from agents.reports.design import Design, Factor, Series, described
from agents.reports.results import Experiment, Results
from agents.wording import chance, counted, listed, mean, points, sentence, share
from warehouse_core.episode import DELIVERED

LIKELY = 0.05
"""A difference that chance makes as often as this is not called one."""

LITTLE = 0.01
"""Of success: so much more or less changes nothing to speak of."""

OTHER_TASKS = {"layout", "size", "density"}
"""Where these differ, the same seed is another task, and seeds are not compared."""


class Answer(NamedTuple):
    """A question, and the sentences that answer it."""

    question: str
    sentences: tuple[str, ...]


class Point(NamedTuple):
    """A value of the factor in question.

    Attributes:
        name: the factor and its value, ``battery 20``.
        case_id: of its case.
        results: of that case.
    """

    name: str
    case_id: int
    results: Results


def answers(experiment: Experiment, design: Design) -> tuple[Answer, ...]:
    """Return an answer for each factor; where nothing differs, one to what became of it all."""
    found = []
    for factor in design.factors:
        rows = design.series(factor)
        if rows:
            words = map(sentence, _sentences(experiment, factor, rows))
            found.append(Answer(question_of(factor), tuple(words)))
    if not found:
        results = experiment.results(*design.labels)
        found.append(Answer("How does it do?", tuple(map(sentence, _alone(results)))))
    return tuple(found)


def question_of(factor: Factor) -> str:
    """Return what is asked where a factor differs."""
    setting = SETTINGS.get(factor.name)
    return setting.question if setting else f"What does {factor.name} change?"


def _alone(results: Results) -> Iterator[str]:
    yield f"{share(results.success)} of {counted(results.episodes, 'episode')} are delivered"
    if results.steps:
        yield f"a delivery takes {mean(results.steps, 'steps', _shortest(results))}"
    yield from _time_and_energy([Point("", 0, results)])
    yield from _failures([Point("", 0, results)])


def _sentences(experiment: Experiment, factor: Factor, rows: Sequence[Series]) -> Iterator[str]:
    row, *others = rows
    line = [
        Point(f"{factor.name} {shown(value)}", case_id, experiment.results(case_id))
        for value, case_id in row.cases.items()
    ]
    where = f"with {described(row.others)}, " if described(row.others) else ""
    if factor.is_ordered and len(line) > 2:
        ends = line[0], line[-1]
        yield where + _trend(line)
    else:
        ranked = sorted(line, key=lambda point: -_success(point))
        ends = ranked[0], ranked[-1]
        yield where + _ranking(ranked)
    if factor.name not in OTHER_TASKS:
        yield from _seed_by_seed(*ends, compare(experiment.store, ends[0].case_id, ends[1].case_id))
    yield from _lengths(ends)
    yield from _time_and_energy(line)
    yield from _failures(ends)
    if others:
        yield _elsewhere(experiment, row.cases, others)


def _trend(line: Sequence[Point]) -> str:
    """Say how success goes from the first value to the last."""
    first, last = line[0], line[-1]
    best, worst = (pick(line, key=_success) for pick in (max, min))
    if _success(best) - _success(worst) < LITTLE:
        return (
            f"success is all but the same, {share(first.results.success)} at {first.name} and "
            f"{share(last.results.success)} at {last.name}"
        )
    words = (
        f"success {'rises' if _success(first) <= _success(last) else 'falls'} from "
        f"{share(first.results.success)} at {first.name} to "
        f"{share(last.results.success)} at {last.name}"
    )
    for extreme, name in ((best, "highest"), (worst, "lowest")):
        if min(abs(_success(extreme) - _success(end)) for end in (first, last)) >= LITTLE:
            words += f"; it is {name} at {extreme.name}, {share(extreme.results.success)}"
    return words


def _ranking(ranked: Sequence[Point]) -> str:
    """Say the success with each value, the best first."""
    shares = [f"{share(point.results.success)} with {point.name}" for point in ranked]
    return f"success is {listed(shares)}"


def _seed_by_seed(one: Point, other: Point, found: Comparison) -> Iterator[str]:
    """Say how two cases differ on the seeds that both have."""
    if not found.seeds:
        yield f"{one.name} and {other.name} share no seed, so they are not compared seed by seed"
        return
    seeds = f"of the same {counted(found.seeds, 'seed')}"
    if not found.only_first + found.only_second:
        yield f"{seeds}, both {one.name} and {other.name} deliver the same ones"
    else:
        verdict = "more than" if found.chance < LIKELY else "no more than"
        yield (
            f"{seeds}, {_or_none(found.only_first)} are delivered only with {one.name} and "
            f"{_or_none(found.only_second)} only with {other.name}, {verdict} chance explains "
            f"({chance(found.chance)})"
        )
    yield from _fate(one, other, found)
    if found.both:
        yield _where_both_deliver(one, other, found)


def _fate(one: Point, other: Point, found: Comparison) -> Iterator[str]:
    """Say what became, with the better value, of what fails most often with the worse one."""
    turned = found.only_second > found.only_first
    better, worse = (other, one) if turned else (one, other)
    changes = {
        (theirs, ours) if turned else (ours, theirs): count
        for (ours, theirs), count in found.changes.items()
    }
    failed = _totals({pair: count for pair, count in changes.items() if pair[1] != DELIVERED}, 1)
    if not failed or found.only_first == found.only_second:
        return
    mode = max(failed, key=lambda each: failed[each])
    fates = _totals({pair: count for pair, count in changes.items() if pair[1] == mode}, 0)
    (most, count), *others = sorted(fates.items(), key=lambda each: -each[1])
    parts = [f"{count:,} end as {most} with {better.name}"]
    parts += [f"{count:,} as {fate}" for fate, count in others]
    yield (
        f"of {counted(failed[mode], 'episode')} that {_ends(failed[mode])} as {mode} with "
        f"{worse.name}, {listed(parts)}"
    )


def _totals(changes: Mapping[tuple[str, str], int], side: int) -> dict[str, int]:
    found: dict[str, int] = {}
    for pair, count in changes.items():
        found[pair[side]] = found.get(pair[side], 0) + count
    return found


def _where_both_deliver(one: Point, other: Point, found: Comparison) -> str:
    steps = (
        f"where both deliver ({counted(found.both, 'seed')}), it takes {found.first:.1f} steps "
        f"with {one.name} and {found.second:.1f} with {other.name}"
    )
    if found.difference is None or found.difference == (0, 0, 0):
        return steps
    estimate, low, high = found.difference
    if low <= 0 <= high:
        return f"{steps}, a difference that chance explains"
    nearer, further = sorted((abs(low), abs(high)))
    less = Interval(abs(estimate), nearer, further)
    return f"{steps}, {mean(less, 'more' if estimate > 0 else 'fewer')}"


def _lengths(ends: Sequence[Point]) -> Iterator[str]:
    """Say what all deliveries take; those of one value may be the easy ones alone."""
    parts = [
        f"{mean(point.results.steps, 'steps', _shortest(point.results))} with {point.name}"
        for point in ends
        if point.results.steps
    ]
    if parts:
        yield f"the mean of all deliveries, easy and hard, is {listed(parts)}"


def _time_and_energy(line: Sequence[Point]) -> Iterator[str]:
    """Say what deliveries cost, where the backend measures it."""
    for point in line:
        results = point.results
        if results.is_measured and results.seconds and results.joules:
            where = f" with {point.name}" if point.name else ""
            yield (
                f"a delivery{where} takes {mean(results.seconds, 's')} and "
                f"{mean(results.joules, 'J')}"
            )


def _failures(ends: Sequence[Point]) -> Iterator[str]:
    """Say what the failures come from."""
    for point in ends:
        modes = {mode: n for mode, n in point.results.modes.items() if mode != DELIVERED}
        where, failures = f" with {point.name}" if point.name else "", sum(modes.values())
        if not failures:
            yield f"no episode{where} fails"
        elif len(modes) == 1:
            [mode] = modes
            yield f"every failure{where} is {mode} ({counted(failures, 'episode')})"
        else:
            ranked = sorted(modes.items(), key=lambda each: -each[1])
            parts = [f"{count / failures:.0%} {mode}" for mode, count in ranked]
            yield f"failures{where} are {listed(parts)} ({counted(failures, 'episode')})"


def _elsewhere(experiment: Experiment, cases: Mapping[Value, int], rows: Sequence[Series]) -> str:
    """Say between what the change of success lies in the other rows of cases."""
    values = [*cases]
    first, last = shown(values[0]), shown(values[-1])
    changes = []
    for row in rows:
        ids = [*row.cases.values()]
        start, end = (experiment.results(ids[place]).share for place in (0, -1))
        changes.append((end - start, described(row.others)))
    least, most = min(changes), max(changes)
    if len(rows) == 1:
        return f"with {least[1]}, success changes by {points(least[0])} from {first} to {last}"
    return (
        f"in the other {len(rows)} combinations success changes from {first} to {last} by between "
        f"{points(least[0])} ({least[1]}) and {points(most[0])} ({most[1]})"
    )


def _shortest(results: Results) -> str:
    return "" if results.needed is None else f"; shortest ways {results.needed:.1f}"


def _success(point: Point) -> float:
    return point.results.share


def _or_none(count: int) -> str:
    return f"{count:,}" if count else "none"


def _ends(count: int) -> str:
    return "ends" if count == 1 else "end"
