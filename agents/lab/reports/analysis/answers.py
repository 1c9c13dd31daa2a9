"""The answers of a report: for each parameter that differs its question, answered from the data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from agents.lab.parameters import PARAMETERS
from agents.lab.reports.analysis import deliveries, fleets
from agents.lab.reports.analysis.question import MAX_DESCRIBED, FactorValue, Question
from agents.lab.reports.analysis.results import LONE, Experiment
from agents.lab.trials.wording import sentence
from warehouse_core.wording import counted

APART = "no two of the combinations differ in one setting alone, so they cannot be compared"


class Answer(NamedTuple):
    """A question, the sentence that answers it, and the sentences that say how it is known."""

    question: str
    verdict: str
    sentences: tuple[str, ...]


def answers(experiment: Experiment) -> tuple[Answer, ...]:
    """Return an answer for each factor, or one about all episodes if nothing differs."""
    told = deliveries.told if experiment.kind is LONE else fleets.told
    found = []
    for factor in experiment.design.factors:
        if series := experiment.design.series(factor):
            parameter = PARAMETERS.get(factor.name)
            question = parameter.question if parameter else f"What does {factor.name} change?"
            main, *others = series
            found.append(_answer(question, told(Question(experiment, factor, main, others))))
    return tuple(found) or (_answer("How does it do?", _apart(experiment)),)


def _answer(question: str, told: Iterable[str]) -> Answer:
    verdict, *sentences = map(sentence, told)
    return Answer(question, verdict, tuple(sentences))


def _apart(experiment: Experiment) -> Iterator[str]:
    """Describe the first cases one by one, as none of them can be compared with another."""
    alone = deliveries.alone if experiment.kind is LONE else fleets.alone
    labels, points = experiment.design.labels, []
    for case_id in list(labels)[:MAX_DESCRIBED]:
        name = experiment.design.name_of(case_id)
        points.append(FactorValue(name, case_id, experiment.results(case_id)))
    in_short, *_ = alone(points[0])
    yield APART if len(points) > 1 else in_short
    for point in points:
        _, *sentences = alone(point)
        yield from sentences
    left = len(labels) - MAX_DESCRIBED
    if left > 0:
        yield f"{counted(left, 'further combination')} cannot be compared with these"
