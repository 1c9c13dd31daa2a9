"""The measures of a report and their intervals, computed from the episodes of some cases.

Two cases are compared seed by seed, because equal seeds are equal tasks.
"""

from __future__ import annotations

from collections import Counter
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from agents.lab.experiments.case import Case, row_type
from agents.lab.experiments.store import TABLE_OF, Store
from agents.lab.reports.design import Design, make_design
from agents.lab.trials.interval import (
    Interval,
    mean_interval,
    paired_share_interval,
    share_interval,
)
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from agents.lab.trials.wording import mean, percent, share
from warehouse_core.records.episode import DELIVERED

CaseIds = tuple[int, ...]


class ReportedMeasure(NamedTuple):
    """A measure that reports show in the table, in a chart and in sentences.

    Attributes:
        name: Name of its picture and of its column in the table.
        title: Title of its chart, and its name in verdicts.
        says: Beginning of a sentence that ends with values, such as ``"a delivery takes"``.
        unit: Unit, or ``"%"`` for a share.
        value: SQL expression for its value in an episode, which is ``NULL`` if it has none.
        of: SQL condition that selects the episodes that have a value.
        what: Definition of the measure, for the caption.
        is_physical: True if only backends that simulate time and energy measure it.
    """

    name: str
    title: str
    says: str
    unit: str
    value: str
    of: str = "TRUE"
    what: str = "mean of all episodes"
    is_physical: bool = False

    def words(self, interval: Interval) -> str:
        """Return a value with its interval as text."""
        return share(interval) if self.unit == "%" else mean(interval, self.unit)

    def short(self, value: float) -> str:
        """Return a value without an interval as text."""
        return percent(value) if self.unit == "%" else mean(Interval(value), self.unit)

    def change(self, difference: Interval) -> str:
        """Return a difference with its interval as text, such as ``4.2 points more (1 to 7)``."""
        more = "more" if difference.estimate > 0 else "less"
        if self.unit == "%":
            difference, unit = Interval(*(100 * each for each in difference)), "points"
        else:
            unit = self.unit
        return mean(abs(difference), f"{unit} {more}")


def _of_deliveries(
    name: str, title: str, says: str, unit: str, *, is_physical: bool
) -> ReportedMeasure:
    of, what = f"mode = '{DELIVERED}'", "mean over all deliveries, hard or easy"
    return ReportedMeasure(name, title, says, unit, name, of, what, is_physical)


SUCCESS = ReportedMeasure(
    "success", "Success", "success is", "%", f"mode = '{DELIVERED}'", what="share of all episodes"
)
STEPS = _of_deliveries(
    "steps", "Steps of a delivery", "a delivery takes", "steps", is_physical=False
)
SECONDS = _of_deliveries("seconds", "Time of a delivery", "a delivery takes", "s", is_physical=True)
JOULES = _of_deliveries("joules", "Energy of a delivery", "a delivery uses", "J", is_physical=True)

STOPPED = "blocked_by_wall + blocked_by_robot + blocked_by_person"
PER_HOUR = ReportedMeasure(
    "per_hour", "Rate of deliveries", "the rate of deliveries is", "per hour", "ifnull(per_hour, 0)"
)
ON_TIME = ReportedMeasure("on_time", "Share on time", "the share on time is", "%", "on_time")
LATENESS = ReportedMeasure(
    "lateness", "Lateness of a delivery", "the lateness of a delivery is", "steps", "mean_lateness"
)
ENERGY = ReportedMeasure(
    "energy", "Energy of a delivery", "a delivery uses", "kJ", "joules_per_delivery / 1000",
    what="energy of all robots, mean of all episodes",
)  # fmt: skip
BLOCKED = ReportedMeasure(
    "blocked", "Share of moves that robots blocked", "the share of moves that robots blocked is",
    "%", f"blocked_by_robot * 1.0 / nullif(distance + {STOPPED}, 0)",
)  # fmt: skip


class ReportKind(NamedTuple):
    """The contents of reports on lone robots or on fleets.

    Attributes:
        name: Phrase that follows the number of episodes.
        row: Type of the rows.
        measures: Measures; values are compared by the first one.
        modes: Name of the picture of the outcomes.
        modes_title: Title of this picture.
    """

    name: str
    row: type[AnyRow]
    measures: tuple[ReportedMeasure, ...]
    modes: str
    modes_title: str


LONE = ReportKind("", Row, (SUCCESS, STEPS, SECONDS, JOULES), "modes", "Outcomes of the episodes")
FLEETS = ReportKind(
    " of fleets", FleetRow, (PER_HOUR, ON_TIME, LATENESS, ENERGY, BLOCKED), "fleet-modes",
    "Outcomes of the fleets",
)  # fmt: skip


class Results:
    """The results of some cases, which are read from the file when they are needed.

    Attributes:
        episodes: Number of episodes.
        modes: Number of episodes with each mode that occurs, in the order of ``MODES_OF``.
        seeds: First seed and last seed.
        is_measured: True if seconds and joules are measured; on the grid they are nominal.
    """

    def __init__(self, experiment: Experiment, case_ids: CaseIds) -> None:
        self.store, self.kind, self.case_ids = experiment.store, experiment.kind, case_ids
        modes, ends = Counter[str](), set[int]()
        for case_id in case_ids:
            for mode, episodes, *seeds in experiment.tallies[case_id]:
                modes[mode] += episodes
                ends.update(seeds)
        self.episodes, self.seeds = modes.total(), (min(ends), max(ends))
        self.modes = {mode: modes[mode] for mode in MODES_OF[self.kind.row] if mode in modes}
        self.is_measured = all(experiment.cases[each]["backend"] != "grid" for each in case_ids)
        self._intervals: dict[ReportedMeasure, Interval | None] = {}

    def has(self, measure: ReportedMeasure) -> bool:
        """Return whether these cases measure it, instead of assuming a nominal value."""
        return self.is_measured or not measure.is_physical

    def interval(self, measure: ReportedMeasure) -> Interval | None:
        """Return the mean or the share of a measure, or ``None`` if no episode has a value."""
        if measure not in self._intervals:
            values = self._values(measure)
            self._intervals[measure] = (
                share_interval(int(values.sum()), len(values))
                if measure is SUCCESS
                else mean_interval(values)
            )
        return self._intervals[measure]

    @property
    def main(self) -> Interval:
        """Interval of the measure by which values are compared."""
        interval = self.interval(self.kind.measures[0])
        assert interval is not None, "every case with episodes has it"
        return interval

    def _values(self, measure: ReportedMeasure) -> np.ndarray:
        """Return the values ``[n]`` of a measure in the episodes that have a value."""
        statement = f"SELECT value FROM ({_values_of(measure, self.kind)})"
        return np.concatenate([_numbers(self.store, statement, each) for each in self.case_ids])


class Experiment:
    """The cases of one kind in a file of results, and their results, each computed once.

    Attributes:
        tallies: Mode, number of episodes, first seed and last seed for each mode that occurs, by
            the number of the case.
        cases: Cases with episodes, by their numbers.
        unbegun: Number of cases of this kind without an episode.
    """

    def __init__(self, store: Store, kind: ReportKind) -> None:
        self.store, self.kind = store, kind
        store.check_rows()
        self.tallies: dict[int, list[tuple[Any, ...]]] = {}
        for case_id, *tally in store.query(
            "SELECT case_id, mode, count(*), min(seed), max(seed) "
            f"FROM {TABLE_OF[kind.row]} GROUP BY case_id, mode"
        ):
            self.tallies.setdefault(case_id, []).append(tuple(tally))
        cases = store.cases()
        self.cases: dict[int, Case] = {case_id: cases[case_id] for case_id in self.tallies}
        self.unbegun = sum(row_type(case) is kind.row for case in cases.values()) - len(self.cases)
        self._results: dict[CaseIds, Results] = {}
        self._paired: dict[tuple[ReportedMeasure, int, int], Interval | None] = {}

    @cached_property
    def design(self) -> Design:
        """Design of the experiment, with the differences between its cases."""
        return make_design(self.cases)

    def results(self, *case_ids: int) -> Results:
        """Return the pooled results of some cases."""
        if case_ids not in self._results:
            self._results[case_ids] = Results(self, case_ids)
        return self._results[case_ids]

    def paired(self, measure: ReportedMeasure, one: int, other: int) -> Interval | None:
        """Return how much larger a measure is in one case than in another, compared seed by seed.

        Only seeds for which both cases have a value are compared. Return ``None`` if there are no
        such seeds.
        """
        if (key := (measure, one, other)) not in self._paired:
            self._paired[key] = self._compare(measure, one, other)
        return self._paired[key]

    def _compare(self, measure: ReportedMeasure, one: int, other: int) -> Interval | None:
        values = _values_of(measure, self.kind)
        pairs = f"SELECT a.value - b.value FROM ({values}) a JOIN ({values}) b USING (seed)"
        found = _numbers(self.store, pairs, one, other)
        if measure is SUCCESS and len(found):
            return paired_share_interval(int((found > 0).sum()), int((found < 0).sum()), len(found))
        return mean_interval(found)


def _values_of(measure: ReportedMeasure, kind: ReportKind) -> str:
    """Return the query for the seeds and the values of a measure in a case."""
    return (
        f"SELECT seed, {measure.value} AS value FROM {TABLE_OF[kind.row]} "
        f"WHERE case_id = ? AND {measure.of} AND {measure.value} IS NOT NULL"
    )


def _numbers(store: Store, statement: str, *case_ids: int) -> np.ndarray:
    return np.fromiter((value for (value,) in store.query(statement, *case_ids)), dtype=float)
