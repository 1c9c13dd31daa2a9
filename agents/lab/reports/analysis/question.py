"""A question of a report: a parameter that differs, and the cases that answer it.

A question is answered by the series of its parameter that is nearest to the defaults; the other
series are summarised in one sentence. Sentences begin in lower case and have no full stop;
``wording.sentence`` adds both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from agents.lab.parameters import shown
from agents.lab.reports.analysis import verdicts
from agents.lab.reports.analysis.design import CaseSeries, Factor, described
from agents.lab.reports.analysis.results import Experiment, Results
from warehouse_core.wording import counted, listed

HARDEST_FIRST = "layout"
"""Factor whose question is which value is hardest; for others it is which value does best."""

MAX_DESCRIBED = 4
"""Values that have sentences of their own at most."""

MAX_NAMED = 6
"""Values in a list at most."""

MIN_CHANGE = 0.01
"""Smallest change of the main measure that is reported as one."""


class FactorValue(NamedTuple):
    """A value of the factor in question: its name, such as ``battery 20``, and its case.

    The name is empty if nothing differs.
    """

    name: str
    case_id: int
    results: Results

    @property
    def value(self) -> float:
        """The main measure of the case."""
        return self.results.main.estimate

    @property
    def which(self) -> str:
        """The name after ``with``, as a part of a sentence."""
        return f" with {self.name}" if self.name else ""


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

    def verdict(
        self,
        words: Callable[[float], str],
        measure: str,
        unit: str,
        *,
        is_clear: bool | None = None,
    ) -> str:
        """Return the verdict on the factor, by the name, the unit and the words of a measure.

        It is clear if the ends of a trend, or the first two of a ranking, differ seed by seed, and
        ``None`` if only their intervals tell.
        """
        line = self.line(self.main) if self.is_trend else self.ranked(self.main)
        places = [
            verdicts.Standing(point.name, point.results.main, words(point.value)) for point in line
        ]
        if self.is_trend:
            return verdicts.trend(measure, places, is_clear=is_clear)
        verbs = verdicts.HARDEST if self.is_hardest else verdicts.BEST
        return verdicts.ranking(places, verbs, unit, is_clear=is_clear)


def numbers(line: Sequence[FactorValue]) -> Iterator[str]:
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


def no_common_seed(one: FactorValue, other: FactorValue) -> str:
    """Say that two cases cannot be compared seed by seed."""
    return f"{one.name} and {other.name} share no seed, so they are not compared seed by seed"
