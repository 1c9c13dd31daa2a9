"""Sentences about the results of some cases.

They begin in lower case and have no full stop; ``wording.sentence`` adds both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Generic, NamedTuple

from agents.lab.evaluation.interval import Interval
from agents.lab.evaluation.wording import chance, mean, percent, share
from agents.lab.reports.analysis.comparison import Comparison, Costs
from agents.lab.reports.analysis.results import AnyResults, Deliveries
from warehouse_core.records.episode import DELIVERED
from warehouse_core.wording import counted, listed

SIGNIFICANCE = 0.05
"""A difference is reported as one if chance explains it with a smaller probability."""

MIN_CHANGE = 0.01
"""Smaller changes of success are not reported as such."""

MAX_NAMED = 6
"""Values in a list; of more only the best and the worst."""

UNITS = {"steps": "steps", "seconds": "s", "joules": "J"}


class Point(NamedTuple, Generic[AnyResults]):
    """A value of the factor in question.

    Attributes:
        name: the factor and its value, ``battery 20``; empty if nothing differs.
        case_id: of its case.
        results: of that case.
    """

    name: str
    case_id: int
    results: AnyResults


def alone(point: Point[Deliveries]) -> str:
    """Give the success of one case."""
    results = point.results
    return (
        f"success is {share(results.success)}{_with(point)} over "
        f"{counted(results.episodes, 'episode')}"
    )


def alone_in_short(point: Point[Deliveries]) -> str:
    """Give the success of one case without its interval."""
    results = point.results
    return f"{percent(results.share)} of {counted(results.episodes, 'episode')} are delivered"


def trend(line: Sequence[Point[Deliveries]]) -> str:
    """Describe how success changes from the first value to the last."""
    first, last = line[0], line[-1]
    best, worst = (pick(line, key=lambda point: point.results.share) for pick in (max, min))
    if best.results.share - worst.results.share < MIN_CHANGE:
        return (
            f"success is all but the same, {share(first.results.success)} at {first.name} and "
            f"{share(last.results.success)} at {last.name}"
        )
    change = last.results.share - first.results.share
    verb, joint = "rises from" if change > 0 else "falls from", "to"
    if abs(change) < MIN_CHANGE:
        verb, joint = "is nearly the same at both ends,", "and"
    words = (
        f"success {verb} {share(first.results.success)} at {first.name} {joint} "
        f"{share(last.results.success)} at {last.name}"
    )
    ends = [point.results.success for point in (first, last)]
    if best.results.success.low > max(end.high for end in ends):
        words += f"; it is highest at {best.name}, {share(best.results.success)}"
    if worst.results.success.high < min(end.low for end in ends):
        words += f"; it is lowest at {worst.name}, {share(worst.results.success)}"
    return words


def ranking(ranked: Sequence[Point[Deliveries]]) -> str:
    """List the success with each value, the best first."""
    named = ranked if len(ranked) <= MAX_NAMED else [*ranked[: MAX_NAMED - 1], ranked[-1]]
    shares = [f"{share(point.results.success)} with {point.name}" for point in named]
    left = f"; {len(ranked) - len(named)} others lie between" if len(named) < len(ranked) else ""
    return f"success is {listed(shares)}{left}"


def numbers(line: Sequence[Point[AnyResults]]) -> Iterator[str]:
    """Give the number of episodes with each value if that differs: few prove less than many."""
    ranked = sorted(line, key=lambda point: -point.results.episodes)
    most, fewest = (counted(ranked[end].results.episodes, "episode") for end in (0, -1))
    if most == fewest:
        return
    if len(line) > MAX_NAMED:
        yield f"there are from {fewest} with {ranked[-1].name} to {most} with {ranked[0].name}"
    else:
        parts = [f"{counted(each.results.episodes, 'episode')}{_with(each)}" for each in ranked]
        yield f"there are {listed(parts)}"


def seed_by_seed(
    one: Point[Deliveries], other: Point[Deliveries], found: Comparison
) -> Iterator[str]:
    """Describe how two cases differ on the seeds that both have."""
    if not found.seeds:
        yield f"{one.name} and {other.name} share no seed, so they are not compared seed by seed"
        return
    seeds = f"of the same {counted(found.seeds, 'seed')}"
    if not found.only_first + found.only_second:
        yield f"{seeds}, {one.name} and {other.name} deliver the same ones"
    else:
        verdict = "more than" if found.chance < SIGNIFICANCE else "no more than"
        yield (
            f"{seeds}, {one.name} alone delivers {_or_none(found.only_first)} and {other.name} "
            f"alone {_or_none(found.only_second)}, {verdict} chance explains "
            f"({chance(found.chance)})"
        )
    yield from _conversion(one, other, found)
    for column, costs in found.costs.items():
        if column == "steps" or (one.results.is_measured and other.results.is_measured):
            yield _costs(one, other, found.both, UNITS[column], costs)


def lengths(line: Sequence[Point[Deliveries]]) -> Iterator[str]:
    """Give the mean steps of all deliveries; those of one value may be only the easy ones."""
    parts = []
    for point in line:
        results = point.results
        if results.steps and results.needed:
            shortest = f"shortest ways {results.needed:.1f}"
            parts.append(f"{mean(results.steps, 'steps', shortest)}{_with(point)}")
    if parts:
        yield f"the mean of all deliveries, easy and hard, is {listed(parts)}"


def time_and_energy(line: Sequence[Point[Deliveries]]) -> Iterator[str]:
    """Give the time and energy of deliveries where the backend measures them."""
    for point in line:
        results = point.results
        if results.is_measured and results.seconds and results.joules:
            yield (
                f"a delivery{_with(point)}, easy or hard, takes {mean(results.seconds, 's')} and "
                f"{mean(results.joules, 'J')}"
            )


def failures(line: Sequence[Point[AnyResults]]) -> Iterator[str]:
    """Give the shares of the failure modes."""
    for point in line:
        modes = Counter(point.results.modes)
        del modes[DELIVERED]
        total = modes.total()
        if not total:
            yield f"no episode{_with(point)} fails"
        elif len(modes) == 1:
            [mode] = modes
            yield f"every failure{_with(point)} is {mode} ({counted(total, 'episode')})"
        else:
            parts = [f"{percent(count / total)} {mode}" for mode, count in modes.most_common()]
            yield f"failures{_with(point)} are {listed(parts)} ({counted(total, 'episode')})"


def _conversion(
    one: Point[Deliveries], other: Point[Deliveries], found: Comparison
) -> Iterator[str]:
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


def _costs(
    one: Point[Deliveries], other: Point[Deliveries], both: int, unit: str, costs: Costs
) -> str:
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
    size = Interval(abs(estimate), *sorted((abs(low), abs(high))))
    return f"{means}: {other.name} takes {mean(size, 'more' if estimate > 0 else 'less')}"


def _with(point: Point[AnyResults]) -> str:
    return f" with {point.name}" if point.name else ""


def _or_none(count: int) -> str:
    return f"{count:,}" if count else "none"
