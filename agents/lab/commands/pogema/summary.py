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

    def mean(self, over: Numbers | float = 1.0) -> float:
        """Return the mean of the values over others where both are known; NaN if none are."""
        shares = self.ratios(over)
        return float(shares.mean()) if shares.size else math.nan

    def ratios(self, over: Numbers | float) -> Numbers:
        """Return the values over others, where both are known and the others are above 0."""
        both = np.isfinite(self.values) & np.isfinite(over) & (np.asarray(over) > 0)
        found: Numbers = self.values[both] / np.broadcast_to(over, both.shape)[both]
        return found


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

    @property
    def reference(self) -> Score | None:
        """The score that ratios are over, if that algorithm was run."""
        return self.scores.get(REFERENCE[self.kind])


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
    scores = {
        name: Score(np.array(each.values)[episodes], each.seconds)
        for name, each in published().get((kind, collection, robots), {}).items()
    }
    for planner in dict.fromkeys(key.planner for key in mine):
        outcomes = {key.episode: each for key, each in mine.items() if key.planner == planner}
        values = [
            _value(kind, collection, outcomes[episode]) if episode in outcomes else math.nan
            for episode in episodes
        ]
        seconds = float(np.mean([each.seconds for each in outcomes.values()]))
        proved, late = (
            sum(each)
            for each in zip(*((one.proved, one.late) for one in outcomes.values()), strict=True)
        )
        scores[planner] = Score(np.array(values), seconds, proved, late)
    bound = np.array([bounds[episode] for episode in episodes])
    return Group(kind, collection, robots, bound, scores)


def _value(kind: Kind, collection: str, outcome: Outcome) -> float:
    """Return the costs of a plan, or the goals a step."""
    if kind is Kind.LIFELONG:
        return outcome.goals / outcome.steps
    is_solved = 0 <= outcome.steps <= SETS[collection].steps[0]
    return outcome.costs if is_solved else math.inf


def tables(groups: Sequence[Group]) -> Iterator[TextTable]:
    """Yield a table for each kind of episodes: a row for each number of robots of each set."""
    for kind in Kind:
        rows = [group for group in groups if group.kind is kind]
        names = list(dict.fromkeys(name for group in rows for name in group.scores))
        if rows:
            yield TextTable(
                ("set, robots", *names),
                [
                    (
                        f"{group.collection}, {group.robots}",
                        *(cell(group, name) for name in names),
                    )
                    for group in rows
                ],
                f"POGEMA's benchmark, {kind}",
                CAPTION[kind],
            )


CAPTION = {
    Kind.ONE_SHOT: "Episodes solved within the benchmark's limit of steps; costs over the sum of "
    "the shortest ways, mean; costs over LaCAM3's where both solve, mean (worst); seconds of an "
    "episode: processor time of planners here, by the clock of published algorithms.",
    Kind.LIFELONG: "Goals reached in a step, mean; times RHCR's, mean (worst); milliseconds a "
    "step: processor time of planners here, by the clock of published algorithms.",
}


def cell(group: Group, name: str) -> str:
    """Return what an algorithm reaches, in lines; empty if it was not run."""
    score = group.scores.get(name)
    if score is None or not score.episodes:
        return "-"
    lines = []
    if group.kind is Kind.ONE_SHOT:
        lines.append(f"{score.solved} of {score.episodes}")
        if score.solved:
            lines.append(f"{score.mean(group.bound):.3f}")
        if score.proved:
            lines.append(f"{score.proved} optimal")
    else:
        lines.append(f"{score.mean():.2f}")
    if group.reference is not None and name != REFERENCE[group.kind]:
        ratios = score.ratios(group.reference.values)
        if ratios.size:
            worst = ratios.max() if group.kind is Kind.ONE_SHOT else ratios.min()
            lines.append(f"x {ratios.mean():.3f} ({worst:.2f})")
    if group.kind is Kind.ONE_SHOT:
        lines.append(f"{score.seconds:.2f} s")
    else:
        steps = SETS[group.collection].steps[1]
        lines.append(f"{1000 * score.seconds / steps:.1f} ms")
    return "\n".join(lines)


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
