"""The answers of a report: for each parameter that differs its question, answered from the data.

A question is answered by the series of its parameter that is nearest to the defaults; the other
series are summarised in one sentence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from agents.lab.evaluation.wording import percent, points, sentence
from agents.lab.experiments.parameters import PARAMETERS, shown
from agents.lab.reports.analysis import statements, verdicts
from agents.lab.reports.analysis.comparison import Comparison, compare
from agents.lab.reports.analysis.design import Design, Factor, Series, described
from agents.lab.reports.analysis.results import AnyResults, Deliveries, Experiment
from agents.lab.reports.analysis.statements import SIGNIFICANCE, Point
from agents.lab.reports.analysis.verdicts import Place
from warehouse_core.wording import counted

OTHER_TASKS = {"layout", "size", "density", "stations"}
"""If one of these differs, equal seeds are different tasks, and are not compared."""

HARDEST_FIRST = "layout"
"""The question about it is which is hardest; that about others is which does best."""

APART = "no two of the combinations differ in one setting alone, so they cannot be compared"

MAX_DESCRIBED = 4
"""Values that have sentences of their own; of more only the two that are compared."""


class Answer(NamedTuple):
    """A question, the sentence that answers it, and those that say how it is known."""

    question: str
    verdict: str
    sentences: tuple[str, ...]


def answers(experiment: Experiment[Deliveries], design: Design) -> tuple[Answer, ...]:
    """Return an answer for each factor, or one about all episodes if nothing differs."""

    def told(factor: Factor, series: Sequence[Series]) -> Iterator[str]:
        return _sentences(experiment, factor, series)

    return answers_of(design, told, _apart(experiment, design))


def answers_of(
    design: Design,
    told: Callable[[Factor, Sequence[Series]], Iterator[str]],
    apart: Iterator[str],
) -> tuple[Answer, ...]:
    """Return an answer for each factor.

    Args:
        design: of the experiment.
        told: yields the verdict on a factor and its series, and then the other sentences.
        apart: yields those about the first cases, if there is no series.
    """
    found = []
    for factor in design.factors:
        series = design.series(factor)
        if series:
            parameter = PARAMETERS.get(factor.name)
            question = parameter.question if parameter else f"What does {factor.name} change?"
            found.append(_answer(question, told(factor, series)))
    if found:
        return tuple(found)
    told_apart, left = list(apart), len(design.labels) - MAX_DESCRIBED
    if left > 0:
        told_apart.append(f"{counted(left, 'further combination')} cannot be compared with these")
    return (_answer("How does it do?", told_apart),)


def _answer(question: str, told: Iterable[str]) -> Answer:
    verdict, *sentences = map(sentence, told)
    return Answer(question, verdict, tuple(sentences))


def lone_points(experiment: Experiment[AnyResults], design: Design) -> Iterator[Point[AnyResults]]:
    """Yield the first cases, named by what differs; they are not pooled, each is by itself."""
    varied = [factor.name for factor in design.factors]
    for case_id in list(design.labels)[:MAX_DESCRIBED]:
        name = described({each: design.labels[case_id][each] for each in varied})
        yield Point(name, case_id, experiment.results(case_id))


def _apart(experiment: Experiment[Deliveries], design: Design) -> Iterator[str]:
    """Describe cases none of which can be compared with another."""
    points = list(lone_points(experiment, design))
    yield APART if len(points) > 1 else statements.alone_in_short(points[0])
    for point in points:
        yield statements.alone(point)
        yield from statements.lengths([point])
        yield from statements.time_and_energy([point])
        yield from statements.failures([point])


def _sentences(
    experiment: Experiment[Deliveries], factor: Factor, series: Sequence[Series]
) -> Iterator[str]:
    main, *others = series
    line = line_of(experiment, factor, main)
    where = f"with {described(main.others)}, " if described(main.others) else ""
    if is_trend(factor):
        pair, pairs = (line[0], line[-1]), 1
        told: Sequence[Point[Deliveries]] = pair
    else:
        line.sort(key=lambda point: point.results.share, reverse=factor.name != HARDEST_FIRST)
        # The best is compared with the next; that it beats the worst would say little.
        pair, pairs = (line[0], line[1]), math.comb(len(line), 2)
        told = line if len(line) <= MAX_DESCRIBED else pair
    found = None
    if factor.name not in OTHER_TASKS:
        found = compare(experiment.store, pair[0].case_id, pair[1].case_id, pairs)
    yield where + _verdict(factor, line, found)
    yield where + (statements.trend(line) if is_trend(factor) else statements.ranking(line))
    yield from statements.numbers(line)
    if found:
        yield from statements.seed_by_seed(*pair, found)
    yield from statements.lengths(told)
    yield from statements.time_and_energy(told)
    yield from statements.failures(told)
    if others:
        yield (
            _changes(experiment, others)
            if is_trend(factor)
            else _best_elsewhere(experiment, factor, line[0], others)
        ) + _numbers(experiment, line, others)


def _verdict(factor: Factor, line: Sequence[Point[Deliveries]], found: Comparison | None) -> str:
    """Return the verdict on a factor.

    Args:
        factor: in question.
        line: its points, in the order of its values or the first of a ranking first.
        found: the ends of a trend or the first two of a ranking, compared seed by seed.
    """
    places = [
        Place(point.name, point.results.success, percent(point.results.share)) for point in line
    ]
    is_clear = found.chance < SIGNIFICANCE if found and found.seeds else None
    if is_trend(factor):
        return verdicts.trend("success", places, is_clear=is_clear)
    verbs = verdicts.HARDEST if factor.name == HARDEST_FIRST else verdicts.BEST
    return verdicts.ranking(places, verbs, "delivered", is_clear=is_clear)


def is_trend(factor: Factor) -> bool:
    """Return whether the change along a factor is described, and not the best of its values."""
    return factor.is_ordered and len(factor.values) > 2


def line_of(
    experiment: Experiment[AnyResults], factor: Factor, series: Series
) -> list[Point[AnyResults]]:
    """Return the points of a series, in the order of the values of its factor."""
    return [
        Point(f"{factor.name} {shown(value)}", case_id, experiment.results(case_id))
        for value, case_id in series.cases.items()
    ]


def _changes(experiment: Experiment[Deliveries], series: Sequence[Series]) -> str:
    """Give the range of the change of success in the other series."""
    changes = []
    for each in series:
        (low, first), *_, (high, last) = each.cases.items()
        change = experiment.results(last).share - experiment.results(first).share
        changes.append((change, f"from {shown(low)} to {shown(high)}", described(each.others)))
    least, most = min(changes), max(changes)
    if len(series) == 1:
        change, ends_named, others = least
        return f"with {others}, success changes by {points(change)} {ends_named}"
    return (
        f"in the other {len(series)} combinations success changes by between {points(least[0])} "
        f"({least[2]}, {least[1]}) and {points(most[0])} ({most[2]}, {most[1]})"
    )


def _numbers(
    experiment: Experiment[Deliveries], line: Sequence[Point[Deliveries]], series: Sequence[Series]
) -> str:
    """Give the numbers of episodes of other series if they are not all that of a line."""
    ids = {case_id for each in series for case_id in each.cases.values()}
    there = {experiment.results(case_id).episodes for case_id in ids}
    if len(there | {point.results.episodes for point in line}) == 1:
        return ""
    fewest, most = min(there), max(there)
    if fewest < most:
        return f", from {fewest:,} to {most:,} episodes each"
    return f", {counted(most, 'episode')} each"


def _best_elsewhere(
    experiment: Experiment[Deliveries],
    factor: Factor,
    best: Point[Deliveries],
    series: Sequence[Series],
) -> str:
    """Give the range of the lead of the best value, or of the hardest, in the other series."""
    is_hardest = factor.name == HARDEST_FIRST
    leads = []
    for each in series:
        line = line_of(experiment, factor, each)
        others = [point.results.share for point in line if point.name != best.name]
        own = [point.results.share for point in line if point.name == best.name]
        if own and others:
            lead = min(others) - own[0] if is_hardest else own[0] - max(others)
            leads.append((lead, described(each.others)))
    if not leads:
        return f"no other combination has {best.name}"
    of_the_next = "behind the next" if is_hardest else "ahead of the next"
    least, most = min(leads), max(leads)
    if len(leads) == 1:
        return f"with {least[1]}, {best.name} is {points(least[0])} {of_the_next}"
    return (
        f"in the other {len(leads)} combinations {best.name} is between {points(least[0])} "
        f"({least[1]}) and {points(most[0])} ({most[1]}) {of_the_next}"
    )
