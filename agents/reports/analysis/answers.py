"""The answers of a report: for each setting that differs its question, answered from the data.

A question is answered by the row of cases along its setting that is nearest to the defaults; what
is otherwise in the other rows has a sentence of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from agents.evaluation.wording import counted, points, sentence, share
from agents.experiments.parameters import SETTINGS, Value, shown
from agents.reports.analysis import statements
from agents.reports.analysis.comparison import compare
from agents.reports.analysis.design import Design, Factor, Series, described
from agents.reports.analysis.results import Experiment
from agents.reports.analysis.statements import Point

OTHER_TASKS = {"layout", "size", "density"}
"""Where these differ, the same seed is another task, and seeds are not compared."""

FEW = 4
"""Values of which each has its sentence; of more only the two that are compared."""


class Answer(NamedTuple):
    """A question, and the sentences that answer it."""

    question: str
    sentences: tuple[str, ...]


def answers(experiment: Experiment, design: Design) -> tuple[Answer, ...]:
    """Return an answer for each factor; where nothing differs, one to what became of it all."""
    found = []
    for factor in design.factors:
        rows = design.series(factor)
        if rows:
            words = map(sentence, _sentences(experiment, factor, rows))
            found.append(Answer(question_of(factor), tuple(words)))
    if not found:
        point = Point("", 0, experiment.results(*design.labels))
        found.append(Answer("How does it do?", tuple(map(sentence, _alone(point)))))
    return tuple(found)


def question_of(factor: Factor) -> str:
    """Return what is asked where a factor differs."""
    setting = SETTINGS.get(factor.name)
    return setting.question if setting else f"What does {factor.name} change?"


def _alone(point: Point) -> Iterator[str]:
    episodes = counted(point.results.episodes, "episode")
    yield f"success is {share(point.results.success)} over {episodes}"
    yield from statements.lengths([point])
    yield from statements.time_and_energy([point])
    yield from statements.failures([point])


def _sentences(experiment: Experiment, factor: Factor, rows: Sequence[Series]) -> Iterator[str]:
    row, *others = rows
    line = _line(experiment, factor, row)
    where = f"with {described(row.others)}, " if described(row.others) else ""
    if _is_trend(factor):
        pair, pairs = (line[0], line[-1]), 1
        told: Sequence[Point] = pair
        yield where + statements.trend(line)
    else:
        line = _ranked(line)
        # The best against the next: that the worst is worse says little of the best.
        pair, pairs = (line[0], line[1]), math.comb(len(line), 2)
        told = line if len(line) <= FEW else pair
        yield where + statements.ranking(line)
    if factor.name not in OTHER_TASKS:
        found = compare(experiment.store, pair[0].case_id, pair[1].case_id, pairs)
        yield from statements.seed_by_seed(*pair, found)
    yield from statements.lengths(told)
    yield from statements.time_and_energy(told)
    yield from statements.failures(told)
    if others:
        yield (
            _changes(experiment, others)
            if _is_trend(factor)
            else _best_elsewhere(experiment, factor, line[0], others)
        )


def _is_trend(factor: Factor) -> bool:
    return factor.is_ordered and len(factor.values) > 2


def _line(experiment: Experiment, factor: Factor, row: Series) -> list[Point]:
    return [
        Point(f"{factor.name} {shown(value)}", case_id, experiment.results(case_id))
        for value, case_id in row.cases.items()
    ]


def _ranked(line: Sequence[Point]) -> list[Point]:
    return sorted(line, key=lambda point: -point.results.share)


def _changes(experiment: Experiment, rows: Sequence[Series]) -> str:
    """Say between what the change of success lies in the other rows of cases."""
    changes = []
    for row in rows:
        values = [*row.cases]
        ends = values[0], values[-1]
        first, last = (experiment.results(row.cases[end]).share for end in ends)
        changes.append((last - first, _from_to(ends), described(row.others)))
    least, most = min(changes), max(changes)
    if len(rows) == 1:
        change, ends_named, others = least
        return f"with {others}, success changes by {points(change)} {ends_named}"
    return (
        f"in the other {len(rows)} combinations success changes by between {points(least[0])} "
        f"({least[2]}, {least[1]}) and {points(most[0])} ({most[2]}, {most[1]})"
    )


def _from_to(ends: tuple[Value, Value]) -> str:
    return f"from {shown(ends[0])} to {shown(ends[1])}"


def _best_elsewhere(
    experiment: Experiment, factor: Factor, best: Point, rows: Sequence[Series]
) -> str:
    """Say in how many of the other rows of cases the same value is best, and by how much."""
    leads = []
    for row in rows:
        line = _line(experiment, factor, row)
        others = [point.results.share for point in line if point.name != best.name]
        own = [point.results.share for point in line if point.name == best.name]
        if own and others:
            leads.append((own[0] - max(others), described(row.others)))
    if not leads:
        return f"no other combination has {best.name}"
    least, most = min(leads), max(leads)
    if len(leads) == 1:
        return f"with {least[1]}, {best.name} is {points(least[0])} ahead of the next"
    return (
        f"in the other {len(leads)} combinations {best.name} is between {points(least[0])} "
        f"({least[1]}) and {points(most[0])} ({most[1]}) ahead of the next"
    )
