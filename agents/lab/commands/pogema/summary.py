"""What planners reach in POGEMA's benchmark beside its published algorithms, as numbers and text.

All are compared on the same episodes: those that were run here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.lab.commands.pogema.benchmark import SETS, Kind
from agents.lab.commands.pogema.published import REFERENCE, published
from agents.lab.commands.pogema.results import Key
from agents.lab.commands.pogema.trial import Outcome
from agents.lab.console.table import TextTable
from warehouse_core.wording import counted

Numbers = NDArray[np.float64]


class Score(NamedTuple):
    """What an algorithm reaches with a number of robots on a set.

    Attributes:
        values: ``[n]`` sums of costs, infinite where it did not solve an episode within the limit
            of steps, or goals a step; NaN where it was not run.
        seconds: mean seconds of an episode: processor time of planners, and by the clock of
            published algorithms.
        proved: episodes whose costs the planner has proved to be the lowest.
        late: steps that took too long, of all episodes.
    """

    values: Numbers
    seconds: float
    proved: int = 0
    late: int = 0

    @property
    def episodes(self) -> int:
        """Number of episodes that it was run on."""
        return int((~np.isnan(self.values)).sum())

    @property
    def solved(self) -> int:
        """Number of episodes that it solved."""
        return int(np.isfinite(self.values).sum())

    def ratios(self, over: Numbers) -> Numbers:
        """Return the values over others, where both are known and the others are above 0."""
        both = np.isfinite(self.values) & np.isfinite(over) & (over > 0)
        found: Numbers = self.values[both] / over[both]
        return found

    def share(self, other: Score) -> float:
        """Return the sum of the values over another's, where both are known; NaN without any."""
        both = np.isfinite(self.values) & np.isfinite(other.values)
        total = float(other.values[both].sum())
        return float(self.values[both].sum()) / total if total else math.nan


class Group(NamedTuple):
    """The scores of all algorithms with a number of robots on a set, published ones first.

    Attributes:
        bound: ``[n]`` sums of the shortest ways; zeros in lifelong episodes.
    """

    kind: Kind
    collection: str
    robots: int
    bound: Numbers
    scores: dict[str, Score]


def groups_of(results: dict[Key, Outcome]) -> list[Group]:
    """Return the groups of results, in the order of the benchmark."""
    places = {(key.kind, key.collection, key.robots) for key in results}
    order = list(SETS)
    found = []
    for kind, collection, robots in sorted(
        places, key=lambda place: (place[0] is Kind.LIFELONG, order.index(place[1]), place[2])
    ):
        mine = {key: each for key, each in results.items() if key[:3] == (kind, collection, robots)}
        found.append(_group(kind, collection, robots, mine))
    return found


def _group(kind: Kind, collection: str, robots: int, mine: dict[Key, Outcome]) -> Group:
    episodes = sorted({key.episode for key in mine})
    bounds = {key.episode: float(each.bound) for key, each in mine.items()}
    scores = dict[str, Score]()
    for name, each in published().get((kind, collection, robots), {}).items():
        values = np.array(each.values)[episodes]
        if not np.isnan(values).all():
            scores[name] = Score(values, each.seconds)
    for planner in dict.fromkeys(key.planner for key in mine):
        outcomes = {key.episode: each for key, each in mine.items() if key.planner == planner}
        values = np.array(
            [
                _value(kind, collection, outcomes[episode]) if episode in outcomes else math.nan
                for episode in episodes
            ]
        )
        seconds = float(np.mean([each.seconds for each in outcomes.values()]))
        proved, late = (
            sum(each)
            for each in zip(*((one.proved, one.late) for one in outcomes.values()), strict=True)
        )
        scores[planner] = Score(values, seconds, proved, late)
    bound = np.array([bounds[episode] for episode in episodes])
    return Group(kind, collection, robots, bound, scores)


def _value(kind: Kind, collection: str, outcome: Outcome) -> float:
    """Return the costs of a plan, or the goals a step."""
    if kind is Kind.LIFELONG:
        return outcome.goals / outcome.steps
    is_solved = 0 <= outcome.steps <= SETS[collection].steps[0]
    return outcome.costs if is_solved else math.inf


COLUMNS = {
    Kind.ONE_SHOT: ("solved", "optimal", "times the bound", "times LaCAM3", "worst", "seconds"),
    Kind.LIFELONG: ("goals a step", "times RHCR", "worst", "ms a step"),
}
"""Names of the measures of an algorithm, which ``CAPTION`` explains."""

CAPTION = {
    Kind.ONE_SHOT: "Episodes solved within the benchmark's limit of steps, and those in which the "
    "planner has proved that no plan costs less; costs over the sum of the shortest ways, mean; "
    "costs over LaCAM3's where both solve, mean and worst; seconds of an episode: processor time "
    "of planners here, by the clock of published algorithms.",
    Kind.LIFELONG: "Goals reached in a step, mean; their sum over RHCR's, and the worst episode's "
    "share; milliseconds a step: processor time of planners here, by the clock of published "
    "algorithms.",
}


def measures(group: Group, name: str) -> tuple[str, ...]:
    """Return what is measured of an algorithm as texts, empty where nothing is known."""
    score = group.scores[name]
    is_once = group.kind is Kind.ONE_SHOT
    mean = worst = ""
    if name != REFERENCE[group.kind] and (other := group.scores.get(REFERENCE[group.kind])):
        ratios = score.ratios(other.values)
        if ratios.size:
            mean = f"{ratios.mean() if is_once else score.share(other):.3f}"
            worst = f"{ratios.max() if is_once else ratios.min():.2f}"
    if not is_once:
        milliseconds = 1000 * score.seconds / SETS[group.collection].steps[1]
        return f"{np.nanmean(score.values):.2f}", mean, worst, f"{milliseconds:.1f}"
    bound = f"{score.ratios(group.bound).mean():.3f}" if score.solved else ""
    proved = f"{score.proved}" if score.proved else ""
    solved = f"{score.solved} of {score.episodes}"
    digits = 3 if score.seconds < 1 else 1
    return solved, proved, bound, mean, worst, f"{score.seconds:.{digits}f}"


def tables(groups: Sequence[Group]) -> Iterator[TextTable]:
    """Yield a table for each kind of episodes: a row for each number of robots of each set."""
    for kind in Kind:
        rows = [group for group in groups if group.kind is kind]
        names = names_of(rows)
        if rows:
            yield TextTable(
                ("set, robots", *names),
                [
                    (
                        f"{group.collection}, {group.robots}",
                        *(cell(group, name) if name in group.scores else "" for name in names),
                    )
                    for group in rows
                ],
                f"POGEMA's benchmark, {kind}",
                CAPTION[kind],
            )


def cell(group: Group, name: str) -> str:
    """Return what is measured of an algorithm, in lines."""
    first, *more = measures(group, name)
    if group.kind is Kind.ONE_SHOT:
        proved, bound, *more = more
        first = "\n".join(filter(None, [first, proved and f"{proved} optimal", bound]))
    mean, worst, time = more
    ratio = f"x {mean} ({worst})" if mean else ""
    unit = "s" if group.kind is Kind.ONE_SHOT else "ms"
    return "\n".join(filter(None, [first, ratio, f"{time} {unit}"]))


def names_of(groups: Sequence[Group]) -> list[str]:
    """Return the names of the algorithms of some groups, published ones first."""
    return list(dict.fromkeys(name for group in groups for name in group.scores))


def late_steps(groups: Sequence[Group]) -> Iterator[str]:
    """Yield a warning for each planner whose steps took too long."""
    for group in groups:
        for name, score in group.scores.items():
            if score.late:
                yield (
                    f"warning: {name}, {group.collection}, {counted(group.robots, 'robot')}: "
                    f"{counted(score.late, 'step')} took more than --plan-seconds; all robots "
                    "waited"
                )
