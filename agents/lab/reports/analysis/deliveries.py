"""What a report says about lone robots: how many deliver, and what a delivery costs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from agents.lab.parameters import shown
from agents.lab.reports.analysis.comparison import Comparison, PairedCosts, compare
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
from agents.lab.reports.analysis.results import JOULES, SECONDS, STEPS
from agents.lab.trials.wording import chance, mean, percent, points, share
from warehouse_core.records.episode import DELIVERED
from warehouse_core.wording import counted, listed

SIGNIFICANCE = 0.05
"""A difference is reported as one if chance explains it with a smaller probability."""

OTHER_TASKS = {"layout", "size", "density", "stations"}
"""Parameters that make equal seeds different tasks if they differ; such seeds are not compared."""

UNITS = {"steps": "steps", "seconds": "s", "joules": "J"}


def told(question: Question) -> Iterator[str]:
    """Answer a question: first the verdict, then the sentences that say how it is known."""
    line = question.line(question.main)
    pair, pairs = (line[0], line[-1]), 1
    described_points: Sequence[FactorValue] = pair
    if not question.is_trend:
        line = question.ranked(question.main)
        # The best is compared with the next; that it beats the worst would say little.
        pair, pairs = (line[0], line[1]), math.comb(len(line), 2)
        described_points = line if len(line) <= MAX_DESCRIBED else pair
    found, is_clear = None, None
    if question.factor.name not in OTHER_TASKS:
        found = compare(question.experiment.store, pair[0].case_id, pair[1].case_id, pairs)
        is_clear = found.chance < SIGNIFICANCE if found.seeds else None
    yield question.where + question.verdict(percent, "success", "delivered", is_clear=is_clear)
    yield question.where + (trend(line) if question.is_trend else ranking(line))
    yield from numbers(line)
    if found:
        yield from seed_by_seed(*pair, found)
    yield from costs_and_failures(described_points)
    if question.others:
        elsewhere = _changes if question.is_trend else _best_elsewhere
        yield elsewhere(question, line[0]) + _numbers(question, line)


def alone(point: FactorValue) -> Iterator[str]:
    """Describe one case: in short, and then by all sentences."""
    results = point.results
    episodes = counted(results.episodes, "episode")
    yield f"{percent(point.value)} of {episodes} are delivered"
    yield f"success is {share(results.main)}{point.which} over {episodes}"
    yield from costs_and_failures([point])


def trend(line: Sequence[FactorValue]) -> str:
    """Describe how success changes from the first value to the last."""
    first, last = line[0], line[-1]
    best, worst = (pick(line, key=lambda point: point.value) for pick in (max, min))
    if best.value - worst.value < MIN_CHANGE:
        return f"success is all but the same, {_at(first)} and {_at(last)}"
    change = last.value - first.value
    verb, joint = "rises from" if change > 0 else "falls from", "to"
    if abs(change) < MIN_CHANGE:
        verb, joint = "is nearly the same at both ends,", "and"
    words = f"success {verb} {_at(first)} {joint} {_at(last)}"
    ends = [point.results.main for point in (first, last)]
    if best.results.main.low > max(end.high for end in ends):
        words += f"; it is highest at {best.name}, {share(best.results.main)}"
    if worst.results.main.high < min(end.low for end in ends):
        words += f"; it is lowest at {worst.name}, {share(worst.results.main)}"
    return words


def _at(point: FactorValue) -> str:
    return f"{share(point.results.main)} at {point.name}"


def ranking(ranked: Sequence[FactorValue]) -> str:
    """List the success with each value, the best first."""
    named = ranked if len(ranked) <= MAX_NAMED else [*ranked[: MAX_NAMED - 1], ranked[-1]]
    shares = [f"{share(point.results.main)} with {point.name}" for point in named]
    left = f"; {len(ranked) - len(named)} others lie between" if len(named) < len(ranked) else ""
    return f"success is {listed(shares)}{left}"


def seed_by_seed(one: FactorValue, other: FactorValue, found: Comparison) -> Iterator[str]:
    """Describe how two cases differ on the seeds that both have."""
    if not found.seeds:
        yield no_common_seed(one, other)
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


def costs_and_failures(line: Sequence[FactorValue]) -> Iterator[str]:
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
        total = modes.total()
        if not total:
            yield f"no episode{point.which} fails"
        elif len(modes) == 1:
            [mode] = modes
            yield f"every failure{point.which} is {mode} ({counted(total, 'episode')})"
        else:
            parts = [f"{percent(count / total)} {mode}" for mode, count in modes.most_common()]
            yield f"failures{point.which} are {listed(parts)} ({counted(total, 'episode')})"


def _conversion(one: FactorValue, other: FactorValue, found: Comparison) -> Iterator[str]:
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


def _changes(question: Question, _: FactorValue) -> str:
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


def _best_elsewhere(question: Question, best: FactorValue) -> str:
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


def _numbers(question: Question, line: Sequence[FactorValue]) -> str:
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
