"""What reports measure of the episodes of some cases, each with its interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from agents.lab.experiments.case import Case, row_type
from agents.lab.experiments.store import Store
from agents.lab.experiments.tables import TABLE_OF
from agents.lab.reports.analysis.design import Design, make_design
from agents.lab.trials.interval import Interval, mean_interval, share_interval
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from agents.lab.trials.wording import mean, share
from warehouse_core.records.episode import DELIVERED

CaseIds = tuple[int, ...]


class ReportedMeasure(NamedTuple):
    """A number that reports give: in the table, in a chart, and in sentences.

    Attributes:
        name: Name of its picture; its column in the table and its chart have other titles.
        unit: Unit; ``"%"`` for a share.
        value: Expression of SQL that gives the value of an episode, ``NULL`` if it has none.
        what: Definition of the number, for the caption.
        is_physical: Only backends that measure time and energy have it.
    """

    name: str
    column: str
    title: str
    unit: str
    value: str
    what: str = "mean of what was delivered, hard or easy"
    is_physical: bool = False

    @property
    def words(self) -> Callable[[Interval], str]:
        """The function that gives a value with its interval as text."""
        return share if self.unit == "%" else lambda interval: mean(interval, "")


SUCCESS = ReportedMeasure(
    "success", "success", "Delivered", "%", f"mode = '{DELIVERED}'", "share of all episodes"
)
STEPS = ReportedMeasure("steps", "steps", "Steps of a delivery", "steps", "steps")
SECONDS = ReportedMeasure(
    "seconds", "seconds", "Time of a delivery", "s", "seconds", is_physical=True
)
JOULES = ReportedMeasure(
    "joules", "joules", "Energy of a delivery", "J", "joules", is_physical=True
)

MEAN = "mean of all episodes"
STOPPED = "blocked_by_wall + blocked_by_robot + blocked_by_person"
PER_HOUR = ReportedMeasure(
    "per_hour", "items an hour", "Delivered in an hour", "items", "per_hour", MEAN
)
ON_TIME = ReportedMeasure(
    "on_time", "on time", "Delivered on time", "%", "on_time", f"share of the deliveries, {MEAN}"
)
LATENESS = ReportedMeasure(
    "lateness", "lateness", "Lateness of a delivery", "steps", "mean_lateness",
    f"0 if it is on time, {MEAN}",
)  # fmt: skip
ENERGY = ReportedMeasure(
    "energy", "kJ each", "Energy of a delivery", "kJ", "joules_per_delivery / 1000",
    f"that of all robots, {MEAN}",
)  # fmt: skip
BLOCKED = ReportedMeasure(
    "blocked", "blocked", "Moves that other robots blocked", "%",
    f"blocked_by_robot * 1.0 / nullif(distance + {STOPPED}, 0)", MEAN,
)  # fmt: skip


class ReportKind(NamedTuple):
    """What reports on lone robots, or on fleets, are made of.

    Attributes:
        measures: Measures of the report; values are compared by the first.
        counted: Condition of SQL on the episodes that a mean is taken over.
        counts: The same condition in words.
        modes: Name and title of the picture of the outcomes.
    """

    name: str
    row: type[AnyRow]
    measures: tuple[ReportedMeasure, ...]
    counted: str
    counts: str
    modes: tuple[str, str]


LONE = ReportKind(
    "", Row, (SUCCESS, STEPS, SECONDS, JOULES), f"mode = '{DELIVERED}'", "were delivered",
    ("modes", "What became of the episodes"),
)  # fmt: skip
FLEETS = ReportKind(
    " of fleets", FleetRow, (PER_HOUR, ON_TIME, LATENESS, ENERGY, BLOCKED), "TRUE", "were run",
    ("fleet-modes", "What became of the fleets"),
)  # fmt: skip


class Results:
    """The episodes of some cases, read when they are needed.

    Attributes:
        episodes: Number of episodes.
        modes: Number of episodes with each mode that occurs, in the order of ``MODES_OF``.
        seeds: First seed and last seed.
        is_measured: Seconds and joules are measured; the grid has nominal ones.
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

    @property
    def count(self) -> int:
        """The number of episodes that a mean is taken over."""
        return self.modes.get(DELIVERED, 0) if self.kind is LONE else self.episodes

    def interval(self, measure: ReportedMeasure) -> Interval | None:
        """Return the mean or the share of a measure; ``None`` if there is nothing to measure."""
        if measure not in self._intervals:
            if measure is SUCCESS:
                found: Interval | None = share_interval(self.count, self.episodes)
            else:
                found = mean_interval(self.values(measure.value))
            self._intervals[measure] = found or (Interval(0.0) if measure is PER_HOUR else None)
        return self._intervals[measure]

    @property
    def main(self) -> Interval:
        """The measure by which values are compared."""
        interval = self.interval(self.kind.measures[0])
        assert interval is not None, "every case with episodes has it"
        return interval

    @cached_property
    def needed(self) -> float | None:
        """The mean steps of the shortest ways of the deliveries of lone robots."""
        values = self.values("needed")
        return float(values.mean()) if len(values) else None

    def values(self, value: str) -> np.ndarray:
        """Return an expression for the episodes that count and have a value, ``[n]``."""
        statement = (
            f"SELECT {value} FROM {TABLE_OF[self.kind.row]} "
            f"WHERE case_id = ? AND {self.kind.counted} AND {value} IS NOT NULL"
        )
        parts = [
            np.fromiter((value for (value,) in self.store.query(statement, case_id)), dtype=float)
            for case_id in self.case_ids
        ]
        return np.concatenate(parts)


class Experiment:
    """The cases of a file of results with episodes of one kind, and their results, computed once.

    Attributes:
        tallies: Mode, number, first and last seed of episodes of one mode, by the number of a case.
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

    @cached_property
    def design(self) -> Design:
        """What differs between the cases."""
        return make_design(self.cases)

    def results(self, *case_ids: int) -> Results:
        """Return the results of some cases, pooled."""
        if case_ids not in self._results:
            self._results[case_ids] = Results(self, case_ids)
        return self._results[case_ids]
