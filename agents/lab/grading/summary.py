"""A class in numbers: how its points are distributed, and what most miss."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection
from statistics import mean, median
from typing import NamedTuple

from agents.lab.grading.grades import OUTCOMES, POINTS, GradeRow
from agents.lab.grading.rubric import Rubric
from agents.lab.trials.wording import percent
from warehouse_core.wording import counted, listed

PARTS = 10
"""Ranges of points, of the same width, in which submissions are counted."""

OUTCOME = re.compile(r"([\d,]+) (\D+?)(?=, \d| and \d|$)")
"""An outcome in a table of grades and how often it occurs, as ``criteria.outcomes`` writes it."""


class Missed(NamedTuple):
    """How many submissions lack points of a criterion, and the mean share that they have of it."""

    name: str
    points: float
    submissions: int
    share: float


class ClassSummary(NamedTuple):
    """The grades of a class.

    Attributes:
        ranges: number of submissions in each range of points, from the lowest, with its name.
        outcomes: number of episodes with each outcome, the most frequent first.
        missed: criteria, first that which most lack points of.
    """

    submissions: int
    mean: float
    median: float
    full: int
    none: int
    ranges: list[tuple[str, int]]
    outcomes: list[tuple[str, int]]
    missed: list[Missed]

    @property
    def sentences(self) -> list[str]:
        """The points, the criterion that most miss, and the outcomes of all episodes, in words."""
        found = [
            f"mean {self.mean:.1f}, median {self.median:g}; {self.full} have all points, "
            f"{self.none} none"
        ]
        if self.missed and (worst := self.missed[0]).submissions:
            found.append(
                f"most miss {worst.name!r}: {worst.submissions} of {self.submissions} lack points "
                f"of it, and the mean has {percent(worst.share)}"
            )
        if self.outcomes:
            episodes = listed(f"{count:,} {name}" for name, count in self.outcomes)
            found.append(
                f"{counted(sum(count for _, count in self.outcomes), 'episode')}: {episodes}"
            )
        return found


def summary_of(rows: Collection[GradeRow], rubric: Rubric) -> ClassSummary:
    """Return the summary of a table of grades with at least one row."""
    points, most = [float(row[POINTS]) for row in rows], rubric.points
    places = Counter(min(int(each * PARTS / most), PARTS - 1) if most else 0 for each in points)
    outcomes: Counter[str] = Counter()
    for row in rows:
        for count, name in OUTCOME.findall(row[OUTCOMES]):
            outcomes[name] += int(count.replace(",", ""))
    missed = []
    for criterion in rubric.criteria:
        given = [float(row[criterion.name]) for row in rows]
        lacking = sum(each < criterion.points for each in given)
        share = mean(given) / criterion.points if criterion.points else 1.0
        missed.append(Missed(criterion.name, criterion.points, lacking, share))
    return ClassSummary(
        len(points), mean(points), median(points),
        sum(each >= most for each in points), sum(each == 0 for each in points),
        [(f"{n * most / PARTS:g} to {(n + 1) * most / PARTS:g}", places[n]) for n in range(PARTS)],
        outcomes.most_common(),
        sorted(missed, key=lambda each: (-each.submissions, each.share)),
    )  # fmt: skip
