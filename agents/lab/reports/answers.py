"""The answers of a report: for each parameter that differs its question, answered from the data.

A question is answered by the series of its parameter that is nearest to the defaults; one sentence
summarises the other series. The verdict comes first. It claims no more than the intervals do.
Sentences begin in lower case and have no full stop; ``wording.sentence`` adds both.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from agents.lab.parameters import FLEET, PARAMETERS, shown
from agents.lab.reports.design import CaseSeries, Factor, described
from agents.lab.reports.results import (
    BLOCKED,
    ENERGY,
    JOULES,
    LONE,
    ON_TIME,
    SECONDS,
    STEPS,
    Experiment,
    PairedCases,
    PairedCosts,
    ReportedMeasure,
    Results,
    compare,
    rate_difference,
)
from agents.lab.trials.interval import Interval
from agents.lab.trials.wording import chance, mean, percent, points, sentence, share
from warehouse_core.records.episode import DELIVERED
from warehouse_core.wording import counted, listed

APART = "no two of the combinations differ in one setting alone, so they cannot be compared"

HARDEST_FIRST = "layout"
"""Factor whose question is which value is hardest; for others it is which value does best."""

OTHER_TASKS = {"layout", "size", "density", "stations"}
"""Parameters that make equal seeds different tasks if they differ; such seeds are not compared."""

MAX_DESCRIBED, MAX_NAMED, MAX_FIRST = 4, 6, 3
"""Most values with sentences of their own, in a list, and as equally good first ones."""

MIN_CHANGE = 0.01
"""Smallest change of the main measure that is reported as one."""

SIGNIFICANCE = 0.05
"""A difference is reported as one if chance explains it with a smaller probability."""

UNITS = {"steps": "steps", "seconds": "s", "joules": "J"}


class Answer(NamedTuple):
    """A question, the sentence that answers it, and the sentences that say how it is known."""

    question: str
    verdict: str
    sentences: tuple[str, ...]


class FactorValue(NamedTuple):
    """A value of the factor in question: its name, such as ``battery 20``, and its case.

    The name is empty if nothing differs.
    """

    name: str
    case_id: int
    results: Results

    @property
    def main(self) -> Interval:
        """The measure by which values are compared."""
        return self.results.main

    @property
    def value(self) -> float:
        """The estimate of the main measure."""
        return self.main.estimate

    @property
    def short(self) -> str:
        """The main measure in words, without its interval."""
        return self.results.kind.short(self.value)

    @property
    def words(self) -> str:
        """The main measure in words."""
        return self.results.kind.words(self.main)

    @property
    def at(self) -> str:
        """The main measure in words, and the name."""
        return f"{self.words} at {self.name}"

    @property
    def which(self) -> str:
        """The name after ``with``, as a part of a sentence."""
        return f" with {self.name}" if self.name else ""


Line = Sequence[FactorValue]


class Question(NamedTuple):
    """What a factor changes: answered by its main series, and summarised for the others."""

    experiment: Experiment
    factor: Factor
    main: CaseSeries
    others: Sequence[CaseSeries]

    @property
    def is_trend(self) -> bool:
        """Whether the change along the factor is described, and not the best of its values."""
        return self.factor.is_ordered and len(self.factor.values) > 2

    @property
    def is_hardest(self) -> bool:
        """Whether the lowest value is the first, and not the highest."""
        return self.factor.name == HARDEST_FIRST

    @property
    def where(self) -> str:
        """The other settings of the main series, as the beginning of a sentence."""
        return f"with {described(self.main.others)}, " if described(self.main.others) else ""

    def line(self, series: CaseSeries) -> list[FactorValue]:
        """Return the points of a series, in the order of the values of the factor."""
        return [
            FactorValue(
                f"{self.factor.name} {shown(value)}", case_id, self.experiment.results(case_id)
            )
            for value, case_id in series.cases.items()
        ]

    def ranked(self, series: CaseSeries) -> list[FactorValue]:
        """Return the points of a series, the first in question first."""
        line = self.line(series)
        return sorted(line, key=lambda point: point.value, reverse=not self.is_hardest)

    def verdict(self, *, is_clear: bool | None = None) -> str:
        """Return the verdict on the factor.

        It is clear if the ends of a trend, or the first two of a ranking, differ seed by seed, and
        ``None`` if only their intervals tell.
        """
        if self.is_trend:
            return verdict_on_trend(self.line(self.main), is_clear=is_clear)
        return verdict_on_ranking(
            self.ranked(self.main), is_hardest=self.is_hardest, is_clear=is_clear
        )


def answers(experiment: Experiment) -> tuple[Answer, ...]:
    """Return an answer for each factor, or one about all episodes if nothing differs."""
    told = _deliveries if experiment.kind is LONE else _shifts
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
    labels, is_lone = experiment.design.labels, experiment.kind is LONE
    line = [
        FactorValue(experiment.design.name_of(case_id), case_id, experiment.results(case_id))
        for case_id in list(labels)[:MAX_DESCRIBED]
    ]
    episodes = [counted(point.results.episodes, "episode") for point in line]
    in_short = f"{line[0].short} of {episodes[0]}" if is_lone else line[0].words
    yield APART if len(line) > 1 else f"{in_short} are delivered"
    for point, number in zip(line, episodes, strict=True):
        if is_lone:
            yield f"success is {point.words}{point.which} over {number}"
            yield from _costs_and_failures([point])
        else:
            yield f"{point.words} are delivered{point.which} over {number}"
            yield from _measures([point])
    left = len(labels) - MAX_DESCRIBED
    if left > 0:
        yield f"{counted(left, 'further combination')} cannot be compared with these"


def verdict_on_ranking(
    ranked: Line, *, is_hardest: bool = False, is_clear: bool | None = None
) -> str:
    """Return which of two values or more is the first, or which ones cannot be told apart.

    ``is_clear`` says whether the first two differ; if it is ``None``, their intervals decide.
    """
    unit = ranked[0].results.kind.unit
    if not all(point.main.is_known for point in ranked):
        return f"too few episodes to tell: {_ends(ranked, unit)}"
    first, *others = ranked
    if is_clear is None:
        is_clear = _differ(first, others[0])
    alike = [point for point in others if not _differ(first, point)]
    # What differs by its intervals may be no clear difference seed by seed, and the reverse.
    alike = [] if is_clear else alike or others
    if len(alike) == len(others):
        return f"no clear difference: {_ends(ranked, unit)}"
    one, several = ("is hardest", "are hardest") if is_hardest else ("does best", "do best")
    behind = next(point for point in others if point not in alike)
    against = f"against {behind.short} with {behind.name}"
    if not alike:
        return f"{first.name} {one}: {first.short} {unit}, {against}"
    named = [first, *alike][:MAX_FIRST]
    names = [point.name for point in named]
    if len(alike) >= MAX_FIRST:
        names.append(counted(len(alike) + 1 - MAX_FIRST, "other"))
    words = listed([point.short for point in named])
    return f"{listed(names)} {several}, too close to tell apart: {words} {unit}, {against}"


def verdict_on_trend(line: Line, *, is_clear: bool | None = None) -> str:
    """Return whether the main measure rises or falls along a factor, or peaks or dips between.

    It is clear if the ends differ, and ``None`` if only their intervals tell.
    """
    first, last, measure = line[0], line[-1], line[0].results.kind.subject
    peak, dip = _extremes(line)
    if not all(point.main.is_known for point in line):
        told = [f"{each.short} at {each.name}" for each in dict.fromkeys((first, peak, last))]
        return f"too few episodes to tell: {measure} is {listed(told)}"
    both = f"{first.short} at {first.name} and {last.short} at {last.name}"
    for point, word in ((peak, "highest"), (dip, "lowest")):
        if point not in (first, last) and _differ(point, first) and _differ(point, last):
            return f"{measure} is {word} at {point.name}: {point.short}, against {both}"
    if _differ(first, last) if is_clear is None else is_clear:
        verb = "rises" if last.value > first.value else "falls"
        return f"{measure} {verb} from {first.short} at {first.name} to {last.short} at {last.name}"
    return f"no clear change: {measure} is {both}"


def _extremes(line: Line) -> list[FactorValue]:
    """Return the points with the highest and with the lowest value, the first of equal ones."""
    return [pick(line, key=lambda point: point.value) for pick in (max, min)]


def _differ(one: FactorValue, other: FactorValue) -> bool:
    """Return whether the intervals of two results have nothing in common."""
    return one.main.high < other.main.low or other.main.high < one.main.low


def _ends(ranked: Line, unit: str) -> str:
    """Return the first and the last result."""
    first, last = ranked[0], ranked[-1]
    start, joint = ("", "and") if len(ranked) == 2 else ("from ", "to")
    return f"{start}{first.short} {unit} with {first.name} {joint} {last.short} with {last.name}"


def _numbers(line: Line) -> Iterator[str]:
    """Give the number of episodes with each value if that differs: few prove less than many."""
    ranked = sorted(line, key=lambda point: -point.results.episodes)
    most, fewest = (counted(ranked[end].results.episodes, "episode") for end in (0, -1))
    if most == fewest:
        return
    if len(line) > MAX_NAMED:
        yield f"there are from {fewest} with {ranked[-1].name} to {most} with {ranked[0].name}"
    else:
        parts = [f"{counted(each.results.episodes, 'episode')}{each.which}" for each in ranked]
        yield f"there are {listed(parts)}"


def _no_common_seed(one: FactorValue, other: FactorValue) -> str:
    return f"{one.name} and {other.name} share no seed, so they are not compared seed by seed"


def _shares(modes: Counter[str]) -> str:
    """Return the shares of outcomes, the commonest first."""
    return listed([f"{percent(n / modes.total())} {mode}" for mode, n in modes.most_common()])


# Lone robots: how many deliver, and what a delivery costs.


def _deliveries(question: Question) -> Iterator[str]:
    """Answer a question: first the verdict, then the sentences that say how it is known."""
    line = question.line(question.main)
    pair, pairs = (line[0], line[-1]), 1
    described_points: Line = pair
    if not question.is_trend:
        line = question.ranked(question.main)
        # The best is compared with the next; that it beats the worst would say little.
        pair, pairs = (line[0], line[1]), math.comb(len(line), 2)
        described_points = line if len(line) <= MAX_DESCRIBED else pair
    found, is_clear = None, None
    if question.factor.name not in OTHER_TASKS:
        found = compare(question.experiment.store, pair[0].case_id, pair[1].case_id, pairs)
        is_clear = found.chance < SIGNIFICANCE if found.seeds else None
    yield question.where + question.verdict(is_clear=is_clear)
    yield question.where + (_success_trend(line) if question.is_trend else _ranking(line))
    yield from _numbers(line)
    if found:
        yield from _seed_by_seed(*pair, found)
    yield from _costs_and_failures(described_points)
    if question.others:
        elsewhere = _changes(question) if question.is_trend else _leads(question, line[0])
        yield elsewhere + _other_numbers(question, line)


def _success_trend(line: Line) -> str:
    """Describe how success changes from the first value to the last."""
    first, last, (best, worst) = line[0], line[-1], _extremes(line)
    if best.value - worst.value < MIN_CHANGE:
        return f"success is all but the same, {first.at} and {last.at}"
    change = last.value - first.value
    verb, joint = "rises from" if change > 0 else "falls from", "to"
    if abs(change) < MIN_CHANGE:
        verb, joint = "is nearly the same at both ends,", "and"
    words = f"success {verb} {first.at} {joint} {last.at}"
    if best.main.low > max(first.main.high, last.main.high):
        words += f"; it is highest at {best.name}, {best.words}"
    if worst.main.high < min(first.main.low, last.main.low):
        words += f"; it is lowest at {worst.name}, {worst.words}"
    return words


def _ranking(ranked: Line) -> str:
    """List the success with each value, the best first."""
    named = ranked if len(ranked) <= MAX_NAMED else [*ranked[: MAX_NAMED - 1], ranked[-1]]
    shares = [f"{point.words} with {point.name}" for point in named]
    left = f"; {len(ranked) - len(named)} others lie between" if len(named) < len(ranked) else ""
    return f"success is {listed(shares)}{left}"


def _seed_by_seed(one: FactorValue, other: FactorValue, found: PairedCases) -> Iterator[str]:
    """Describe how two cases differ on the seeds that both have."""
    if not found.seeds:
        yield _no_common_seed(one, other)
        return
    seeds = f"of the same {counted(found.seeds, 'seed')}"
    if not found.only_first + found.only_second:
        yield f"{seeds}, {one.name} and {other.name} deliver the same ones"
    else:
        verdict = "more than" if found.chance < SIGNIFICANCE else "no more than"
        first, second = (f"{n:,}" if n else "none" for n in (found.only_first, found.only_second))
        yield (
            f"{seeds}, {one.name} alone delivers {first} and {other.name} alone {second}, "
            f"{verdict} chance explains ({chance(found.chance)})"
        )
    yield from _conversion(one, other, found)
    for column, costs in found.costs.items():
        if column == "steps" or (one.results.is_measured and other.results.is_measured):
            yield _costs(one, other, found.both, UNITS[column], costs)


def _conversion(one: FactorValue, other: FactorValue, found: PairedCases) -> Iterator[str]:
    """Describe what the commonest failures of the worse value become with the better one."""
    if found.only_first == found.only_second:
        return
    side = int(found.only_first > found.only_second)
    better, worse = (one, other) if side else (other, one)
    failed = Counter[str]()
    for pair, count in found.changes.items():
        if pair[side] != DELIVERED:
            failed[pair[side]] += count
    [(mode, total)] = failed.most_common(1)
    outcomes = Counter(
        {pair[1 - side]: count for pair, count in found.changes.items() if pair[side] == mode}
    )
    parts = [f"{outcome} ({count:,})" for outcome, count in outcomes.most_common()]
    yield (
        f"{mode} with {worse.name} ({counted(total, 'episode')}) becomes, with {better.name}, "
        f"{listed(parts)}"
    )


def _costs(one: FactorValue, other: FactorValue, both: int, unit: str, costs: PairedCosts) -> str:
    digits = 0 if max(costs.first, costs.second) >= 1000 else 1
    means = (
        f"where both deliver ({counted(both, 'seed')}), it takes {costs.first:,.{digits}f} {unit} "
        f"with {one.name} and {costs.second:,.{digits}f} with {other.name}"
    )
    estimate, low, high = costs.difference
    if estimate == 0 or not costs.difference.is_known:
        return means
    if low <= 0 <= high:
        return f"{means}, a difference that chance explains"
    more = mean(abs(costs.difference), "more" if estimate > 0 else "less")
    return f"{means}: {other.name} takes {more}"


def _costs_and_failures(line: Line) -> Iterator[str]:
    """Give the mean costs of all deliveries with each value, and the shares of failure modes.

    Deliveries with one value may be only the easy ones.
    """
    lengths = [
        f"{mean(steps, 'steps', f'shortest ways {point.results.needed:.1f}')}{point.which}"
        for point in line
        if (steps := point.results.interval(STEPS)) and point.results.needed
    ]
    if lengths:
        yield f"the mean of all deliveries, easy and hard, is {listed(lengths)}"
    for point in line:
        seconds, joules = point.results.interval(SECONDS), point.results.interval(JOULES)
        if point.results.is_measured and seconds and joules:
            yield (
                f"a delivery{point.which}, easy or hard, takes {mean(seconds, 's')} and "
                f"{mean(joules, 'J')}"
            )
    for point in line:
        modes = Counter(point.results.modes)
        del modes[DELIVERED]
        number = counted(modes.total(), "episode")
        if not modes:
            yield f"no episode{point.which} fails"
        elif len(modes) == 1:
            yield f"every failure{point.which} is {next(iter(modes))} ({number})"
        else:
            yield f"failures{point.which} are {_shares(modes)} ({number})"


def _changes(question: Question) -> str:
    """Give the range of the change of success in the other series."""
    changes = []
    for each in question.others:
        line, (low, *_others, high) = question.line(each), each.cases
        change = line[-1].value - line[0].value
        changes.append((change, f"from {shown(low)} to {shown(high)}", described(each.others)))
    least, most = min(changes), max(changes)
    if len(changes) == 1:
        change, ends_named, others = least
        return f"with {others}, success changes by {points(change)} {ends_named}"
    return (
        f"in the other {len(changes)} combinations success changes by between {points(least[0])} "
        f"({least[2]}, {least[1]}) and {points(most[0])} ({most[2]}, {most[1]})"
    )


def _leads(question: Question, best: FactorValue) -> str:
    """Give the range of the lead of the best value, or of the hardest, in the other series."""
    leads = []
    for each in question.others:
        line = question.line(each)
        others = [point.value for point in line if point.name != best.name]
        own = [point.value for point in line if point.name == best.name]
        if own and others:
            lead = min(others) - own[0] if question.is_hardest else own[0] - max(others)
            leads.append((lead, described(each.others)))
    if not leads:
        return f"no other combination has {best.name}"
    of_the_next = "behind the next" if question.is_hardest else "ahead of the next"
    least, most = min(leads), max(leads)
    if len(leads) == 1:
        return f"with {least[1]}, {best.name} is {points(least[0])} {of_the_next}"
    return (
        f"in the other {len(leads)} combinations {best.name} is between {points(least[0])} "
        f"({least[1]}) and {points(most[0])} ({most[1]}) {of_the_next}"
    )


def _other_numbers(question: Question, line: Line) -> str:
    """Give the numbers of episodes of the other series if a line does not have the same."""
    there = {
        point.results.episodes for series in question.others for point in question.line(series)
    }
    if len(there | {point.results.episodes for point in line}) == 1:
        return ""
    fewest, most = min(there), max(there)
    if fewest < most:
        return f", from {fewest:,} to {most:,} episodes each"
    return f", {counted(most, 'episode')} each"


# Fleets: how many items they deliver in an hour, and what that costs.


def _shifts(question: Question) -> Iterator[str]:
    """Answer a question: first the verdict, then the sentences that say how it is known."""
    line, ranked = question.line(question.main), question.ranked(question.main)
    most = "fewest" if question.is_hardest else "most"
    yield question.where + _too_many(question, line) + question.verdict()
    if question.is_trend:
        yield question.where + _rate_trend(line)
        described_points: Line = list(dict.fromkeys((line[0], ranked[0], line[-1])))
    else:
        listing = [f"{point.words} with {point.name}" for point in ranked[:MAX_NAMED]]
        yield f"{question.where}{most} are delivered with {ranked[0].name}: {listed(listing)}"
        described_points = ranked[:MAX_DESCRIBED]
    yield from _numbers(line)
    yield from _rates_by_seed(*ranked[:2])
    yield from _measures(described_points)
    if question.others:
        parts = [
            f"{best.name} with {described(each.others)}, {best.words}"
            for each in question.others[:MAX_DESCRIBED]
            for best in question.ranked(each)[:1]
        ]
        left = len(question.others) - len(parts)
        more = f", and {counted(left, 'combination')} more" if left else ""
        yield f"elsewhere {most} are delivered with {'; '.join(parts)}{more}"


def _too_many(question: Question, line: Line) -> str:
    """Return how many robots are too many if that is the question, before its verdict."""
    is_known = all(point.main.is_known for point in line)
    if not (question.is_trend and question.factor.name == FLEET and is_known):
        return ""
    best = max(line, key=lambda point: point.value)
    # The largest fleet that may be as good as the best.
    *_, (enough, largest) = [
        (value, point)
        for value, point in zip(question.main.cases, line, strict=True)
        if point is best or not _delivers_more(best, point)
    ]
    if largest is line[-1]:
        return f"{shown(enough)} are not too many: "
    return f"more than {shown(enough)} are too many: "


def _delivers_more(one: FactorValue, other: FactorValue) -> bool:
    """Return whether more is delivered, seed by seed, or by the intervals if that is unknown."""
    difference = _difference(one, other)
    if difference is None or not difference.is_known:
        return other.main.high < one.main.low
    return difference.low > 0


def _rate_trend(line: Line) -> str:
    """Describe how deliveries change from the first value to the last."""
    first, last, (best, worst) = line[0], line[-1], _extremes(line)
    if best.value - worst.value < MIN_CHANGE * best.value:
        return f"deliveries are all but the same, {first.at} and {last.at}"
    parts = []
    if best is not first:
        parts.append(f"rise from {first.at} to {best.at}")
    if best is not last:
        is_known = last.main.is_known and best.main.is_known
        verb = "are about the same," if is_known else "are"
        verb = "fall to" if last.main.high < best.main.low else verb
        parts.append(f"{verb} {last.at}" if parts else f"fall from {first.at} to {last.at}")
    words = f"deliveries {', and '.join(parts)}"
    near = [each for each in line if each.main.high >= best.main.low]
    if near and near[0] not in (first, best):
        words += f"; the intervals allow as many {near[0].at}"
    return words


def _rates_by_seed(one: FactorValue, other: FactorValue) -> Iterator[str]:
    """Describe how the deliveries of two cases differ on the seeds that both have."""
    difference = _difference(one, other)
    if difference is None:
        yield _no_common_seed(one, other)
    elif difference.is_known and difference.estimate:
        more = "more" if difference.estimate > 0 else "fewer"
        words = (
            "a difference that chance explains"
            if difference.low <= 0 <= difference.high
            else f"{mean(abs(difference), '')} {more} an hour"
        )
        yield f"seed by seed, {one.name} against {other.name}: {words}"


def _difference(one: FactorValue, other: FactorValue) -> Interval | None:
    return rate_difference(one.results.store, one.case_id, other.case_id)


def _measures(line: Line) -> Iterator[str]:
    """Give punctuality, energy, traffic and modes with each value."""
    yield from _each(line, ON_TIME, share, "the share on time is")
    yield from _each(line, ENERGY, lambda interval: mean(interval, "kJ"), "a delivery costs")
    yield from _each(
        line, BLOCKED, lambda interval: percent(interval.estimate),
        "the share of moves that other robots block is",
    )  # fmt: skip
    for point in line:
        yield f"the episodes{point.which} are {_shares(Counter(point.results.modes))}"


def _each(
    line: Line, measure: ReportedMeasure, words: Callable[[Interval], str], about: str
) -> Iterator[str]:
    intervals = [(point, point.results.interval(measure)) for point in line]
    parts = [f"{words(interval)}{point.which}" for point, interval in intervals if interval]
    if parts:
        yield f"{about} {listed(parts)}"
