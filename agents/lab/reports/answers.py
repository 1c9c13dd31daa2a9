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
from agents.lab.reports.design import CaseSeries, Factor, described
from agents.lab.reports.results import LONE, Experiment, Results
from agents.lab.trials.interval import Interval, difference_interval
from agents.lab.trials.wording import percent, sentence
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
    """A value of a factor with its results.

    Attributes:
        name: Name of the value, such as ``battery 20``; it may be empty.
        case_id: Number of the case that has this value.
        results: Results of the case.
    """

    name: str
    case_id: int
    results: Results

    @property
    def estimate(self) -> float:
        """Estimate of the measure by which values are compared."""
        return self.results.main.estimate

    @property
    def short(self) -> str:
        """The estimate in words, without its interval."""
        return self.results.kind.measures[0].short(self.estimate)

    @property
    def which(self) -> str:
        """The name with " with " before it, for a sentence, or "" without a name."""
        return f" with {self.name}" if self.name else ""


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
    verdict, *sentences = map(sentence, lines)
    return Answer(question, verdict, tuple(sentences))


def _compared(
    experiment: Experiment, factor: Factor, series: Sequence[CaseSeries]
) -> Iterator[str]:
    """Yield the verdict on a factor's question, and then the evidence."""
    lines = [_line(experiment, factor, each) for each in series]
    main = lines[0]
    yield _where(series[0]) + verdict(experiment, factor, main)
    named = _named(experiment, factor, main)
    yield from _measures(named)
    if experiment.kind is LONE and factor.name not in OTHER_TASKS:
        yield from _where_both_deliver(experiment, *_pair(factor, main))
    for each, line in list(zip(series, lines, strict=True))[1 : MAX_NAMED + 1]:
        yield _where(each) + verdict(experiment, factor, line)
    left = len(series) - 1 - MAX_NAMED
    if left > 0:
        yield f"the table has {counted(left, 'further combination')}"


def _apart(experiment: Experiment) -> Iterator[str]:
    """Describe the first cases one by one, because no two cases can be compared."""
    design = experiment.design
    line = [
        FactorValue(design.name_of(case_id), case_id, experiment.results(case_id))
        for case_id in list(design.labels)[:MAX_NAMED]
    ]
    measure, alone = experiment.kind.measures[0], line[0].results
    yield APART if len(line) > 1 else f"{measure.says} {measure.short(alone.main.estimate)}"
    yield from _measures(line)
    left = len(design.labels) - MAX_NAMED
    if left > 0:
        yield f"{counted(left, 'further combination')} cannot be compared with these"


def verdict(experiment: Experiment, factor: Factor, line: Sequence[FactorValue]) -> str:
    """Return a sentence that names the best value, or says that no difference was found."""
    measure = experiment.kind.measures[0]
    subject = measure.title.lower()
    if peak := _peak(experiment, factor, line):
        parts = [
            f"{measure.change(_difference(experiment, factor, peak, end))} than{end.which}"
            for end in (line[0], line[-1])
        ]
        return f"{subject} is highest{peak.which}: {peak.short}, {' and '.join(parts)}"
    first, second = _pair(factor, line)
    found = _difference(experiment, factor, first, second)
    both = f"{first.short}{first.which} and {second.short}{second.which}"
    if not found.is_known:
        return f"too few episodes to compare: {subject} is {both}"
    if found.low <= 0 <= found.high:
        return f"no difference was found: {subject} is {both}"
    change = measure.change(found)
    if _is_trend(factor, line):
        verb = "rises" if found.estimate > 0 else "falls"
        ends = f"from {second.short}{second.which} to {first.short}{first.which}"
        return f"{subject} {verb} {ends}: {change}"
    verb = "is hardest" if factor.name == HARDEST_FIRST else "does best"
    return f"{first.name} {verb}: {first.short}, {change} than{second.which}"


def _difference(
    experiment: Experiment, factor: Factor, one: FactorValue, other: FactorValue
) -> Interval:
    """Return how much better one value is, compared seed by seed if equal seeds are equal tasks."""
    measure, cases = experiment.kind.measures[0], (one.case_id, other.case_id)
    found = None if factor.name in OTHER_TASKS else experiment.paired(measure, *cases)
    return found or difference_interval(one.results.main, other.results.main)


def _peak(
    experiment: Experiment, factor: Factor, line: Sequence[FactorValue]
) -> FactorValue | None:
    """Return the best value if it is inside a trend and better than both ends, else ``None``."""
    best = max(line, key=lambda each: each.estimate)
    if not _is_trend(factor, line) or best in (line[0], line[-1]):
        return None
    ends = (_difference(experiment, factor, best, end) for end in (line[0], line[-1]))
    return best if all(each.low > 0 for each in ends) else None


def _pair(factor: Factor, line: Sequence[FactorValue]) -> tuple[FactorValue, FactorValue]:
    """Return the last and the first value of a trend, or else the best and the second best."""
    if _is_trend(factor, line):
        return line[-1], line[0]
    best, following, *_ = _ranked(factor, line)
    return best, following


def _is_trend(factor: Factor, line: Sequence[FactorValue]) -> bool:
    return factor.is_ordered and len(line) > 2


def _ranked(factor: Factor, line: Sequence[FactorValue]) -> list[FactorValue]:
    """Return the values in order, with the best one first, or the hardest for layouts."""
    return sorted(line, key=lambda each: each.estimate, reverse=factor.name != HARDEST_FIRST)


def _named(
    experiment: Experiment, factor: Factor, line: Sequence[FactorValue]
) -> list[FactorValue]:
    """Return the values to describe: both ends and the peak of a trend, or the top of a ranking."""
    if not _is_trend(factor, line):
        return _ranked(factor, line)[:MAX_NAMED]
    peak = _peak(experiment, factor, line)
    return [each for each in (line[0], peak, line[-1]) if each]


def _line(experiment: Experiment, factor: Factor, series: CaseSeries) -> list[FactorValue]:
    """Return the values of a series in their order."""
    return [
        FactorValue(f"{factor.name} {shown(value)}", case_id, experiment.results(case_id))
        for value, case_id in series.cases.items()
    ]


def _where(series: CaseSeries) -> str:
    """Return the other settings of a series in words, to begin a sentence."""
    others = described(series.others)
    return f"with {others}, " if others else ""


def _measures(line: Sequence[FactorValue]) -> Iterator[str]:
    """Yield a sentence for each measure, and one on the outcomes for each value."""
    for measure in line[0].results.kind.measures:
        parts = [
            f"{measure.words(interval)}{each.which}"
            for each in line
            if each.results.has(measure) and (interval := each.results.interval(measure))
        ]
        if parts:
            yield f"{measure.says} {listed(parts)}"
    for each in line:
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
        if not (one.results.has(measure) and other.results.has(measure)):
            continue
        found = experiment.paired(measure, one.case_id, other.case_id)
        if found is None or not found.is_known:
            continue
        begin = f"where both deliver, {one.name}"
        if found.low <= 0 <= found.high:
            yield f"{begin} and {other.name} show no difference in the {measure.title.lower()}"
        else:
            yield f"{begin} takes {measure.change(found)} than {other.name}"
