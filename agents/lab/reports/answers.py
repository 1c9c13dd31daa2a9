"""The answers of a report: a question for each parameter that differs, answered from the data.

The answer comes from the series of cases that is nearest to the defaults. In this series two values
of the parameter are compared seed by seed. The verdict says how much better one value is, or that
no difference was found. Each of the other series gets a verdict too.

If the values have an order, the last value is compared with the first. Otherwise the best value is
compared with the second best. This needs no correction for having selected the best value: Gutmann
and Maymin (1987), Is the selected population the best?
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from agents.lab.parameters import PARAMETERS, shown
from agents.lab.reports.results import LONE, CaseSeries, Experiment, Factor, Results, described
from agents.lab.trials.interval import Interval, difference_interval, percent
from warehouse_core.wording import counted, listed

APART = "no two of the combinations differ in one setting alone, so they cannot be compared"

HARDEST_FIRST = "layout"
"""Factor whose question asks for the hardest value; other questions ask for the best value."""

OTHER_TASKS = {"layout", "size", "density", "stations"}
"""Parameters whose values change the task, so that equal seeds are not equal tasks."""

MAX_NAMED = 4
"""Maximum number of values, series or combinations that are described individually."""


class Answer(NamedTuple):
    """A question, the sentence that answers it, and the sentences with the evidence."""

    question: str
    verdict: str
    sentences: tuple[str, ...]


class FactorValue(NamedTuple):
    """A value of a factor with its name, such as ``battery 20``, which may be empty."""

    name: str
    results: Results

    @property
    def short(self) -> str:
        """The measure by which values are compared, in words, without its interval."""
        return self.results.kind.measures[0].short(self.results.main.estimate)

    @property
    def which(self) -> str:
        """The name with " with " before it, for a sentence, or "" without a name."""
        return f" with {self.name}" if self.name else ""


class ComparedValues:
    """The values of a factor in a series of cases.

    Attributes:
        verdict: Sentence that names the best value, or says that no difference was found.
        named: Values to describe: ends and peak of a trend, or the top of a ranking.
        pair: Last and first value of a trend, or else the best and the second best.
    """

    def __init__(self, experiment: Experiment, factor: Factor, series: CaseSeries) -> None:
        self.experiment, self.factor = experiment, factor
        values = [
            FactorValue(f"{factor.name} {shown(value)}", experiment.results(case_id))
            for value, case_id in series.cases.items()
        ]
        self._is_trend = factor.is_ordered and len(values) > 2
        ranked = sorted(
            values,
            key=lambda each: each.results.main.estimate,
            reverse=factor.name != HARDEST_FIRST,
        )
        first, best, last = values[0], ranked[0], values[-1]
        is_peak = self._is_trend and all(
            end is not best and self._difference(best, end).low > 0 for end in (first, last)
        )
        if self._is_trend:
            self.pair, self.named = (last, first), [first, *([best] if is_peak else []), last]
        else:
            self.pair, self.named = (ranked[0], ranked[1]), ranked[:MAX_NAMED]
        where = described(series.others)
        said = self._peak(best, first, last) if is_peak else self._of_pair(*self.pair)
        self.verdict = f"with {where}, {said}" if where else said

    def _difference(self, one: FactorValue, other: FactorValue) -> Interval:
        """Return how much better a value is, compared by seed if equal seeds are equal tasks."""
        measure, found = self.experiment.kind.measures[0], None
        if self.factor.name not in OTHER_TASKS:
            found = self.experiment.paired(measure, *one.results.case_ids, *other.results.case_ids)
        return found or difference_interval(one.results.main, other.results.main)

    def _peak(self, best: FactorValue, first: FactorValue, last: FactorValue) -> str:
        """Return the verdict on a trend whose best value is better than both ends."""
        measure = self.experiment.kind.measures[0]
        one, other = (
            f"{measure.change(self._difference(best, end))} than{end.which}"
            for end in (first, last)
        )
        return f"{measure.title.lower()} is highest{best.which}: {best.short}, {one} and {other}"

    def _of_pair(self, first: FactorValue, second: FactorValue) -> str:
        measure = self.experiment.kind.measures[0]
        subject, found = measure.title.lower(), self._difference(first, second)
        both = f"{subject} is {first.short}{first.which} and {second.short}{second.which}"
        if not found.is_known:
            return f"too few episodes to compare: {both}"
        if found.low <= 0 <= found.high:
            return f"no difference was found: {both}"
        change = measure.change(found)
        if self._is_trend:
            verb = "rises" if found.estimate > 0 else "falls"
            ends = f"from {second.short}{second.which} to {first.short}{first.which}"
            return f"{subject} {verb} {ends}: {change}"
        verb = "is hardest" if self.factor.name == HARDEST_FIRST else "does best"
        return f"{first.name} {verb}: {first.short}, {change} than{second.which}"


def answers(experiment: Experiment) -> tuple[Answer, ...]:
    """Return an answer for each factor, or one answer about all episodes if nothing differs."""
    found = []
    for factor in experiment.design.factors:
        if series := experiment.design.series(factor):
            parameter = PARAMETERS.get(factor.name)
            question = parameter.question if parameter else f"What does {factor.name} change?"
            found.append(_answer(question, _compared(experiment, factor, series)))
    return tuple(found) or (_answer("What are the results?", _apart(experiment)),)


def _answer(question: str, lines: Iterable[str]) -> Answer:
    verdict, *sentences = [f"{line[0].upper()}{line[1:]}." for line in lines]
    return Answer(question, verdict, tuple(sentences))


def _compared(
    experiment: Experiment, factor: Factor, series: Sequence[CaseSeries]
) -> Iterator[str]:
    """Yield the verdict on a factor's question, and then the evidence."""
    main = ComparedValues(experiment, factor, series[0])
    yield main.verdict
    yield from _measures(main.named)
    if experiment.kind is LONE and factor.name not in OTHER_TASKS:
        yield from _where_both_deliver(experiment, *main.pair)
    for each in series[1 : MAX_NAMED + 1]:
        yield ComparedValues(experiment, factor, each).verdict
    left = len(series) - 1 - MAX_NAMED
    if left > 0:
        yield f"the table has {counted(left, 'further combination')}"


def _apart(experiment: Experiment) -> Iterator[str]:
    """Describe the first cases one by one, because no two cases can be compared."""
    design = experiment.design
    values = [
        FactorValue(design.name_of(case_id), experiment.results(case_id))
        for case_id in list(design.labels)[:MAX_NAMED]
    ]
    yield APART if len(values) > 1 else f"{experiment.kind.measures[0].says} {values[0].short}"
    yield from _measures(values)
    left = len(design.labels) - MAX_NAMED
    if left > 0:
        yield f"{counted(left, 'further combination')} cannot be compared with these"


def _measures(values: Sequence[FactorValue]) -> Iterator[str]:
    """Yield a sentence for each measure, and one on the outcomes for each value."""
    for measure in values[0].results.kind.measures:
        parts = [
            f"{measure.words(interval)}{each.which}"
            for each in values
            if each.results.has(measure) and (interval := each.results.interval(measure))
        ]
        if parts:
            yield f"{measure.says} {listed(parts)}"
    for each in values:
        modes = sorted(each.results.modes.items(), key=lambda pair: -pair[1])
        parts = [f"{percent(count / each.results.episodes)} {mode}" for mode, count in modes]
        number = counted(each.results.episodes, "episode")
        yield f"outcomes{each.which} are {listed(parts)} ({number})"


def _where_both_deliver(
    experiment: Experiment, one: FactorValue, other: FactorValue
) -> Iterator[str]:
    """Compare the costs of deliveries on the seeds that both values deliver.

    On these seeds both values had equally hard tasks.
    """
    for measure in experiment.kind.measures[1:]:
        found = experiment.paired(measure, *one.results.case_ids, *other.results.case_ids)
        has_both = one.results.has(measure) and other.results.has(measure)
        if found is None or not found.is_known or not has_both:
            continue
        begin = f"where both deliver, {one.name}"
        if found.low <= 0 <= found.high:
            yield f"{begin} and {other.name} show no difference in the {measure.title.lower()}"
        else:
            yield f"{begin} takes {measure.change(found)} than {other.name}"
