"""What reports measure of the episodes of some cases, each with its interval.

Two cases are compared seed by seed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from agents.lab.experiments.case import Case, row_type
from agents.lab.experiments.store import TABLE_OF, Store
from agents.lab.reports.design import Design, make_design
from agents.lab.trials.interval import Interval, mean_interval, share_interval
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from agents.lab.trials.wording import mean, percent, share
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
        subject: Name of the first measure in a sentence, and its unit in ``unit``.
        short: Function that gives the first measure without its interval as text.
        words: Function that gives the first measure with its interval as text.
    """

    name: str
    row: type[AnyRow]
    measures: tuple[ReportedMeasure, ...]
    counted: str
    counts: str
    modes: tuple[str, str]
    subject: str
    unit: str
    short: Callable[[float], str]
    words: Callable[[Interval], str]


LONE = ReportKind(
    "", Row, (SUCCESS, STEPS, SECONDS, JOULES), f"mode = '{DELIVERED}'", "were delivered",
    ("modes", "What became of the episodes"), "success", "delivered", percent, share,
)  # fmt: skip
FLEETS = ReportKind(
    " of fleets", FleetRow, (PER_HOUR, ON_TIME, LATENESS, ENERGY, BLOCKED), "TRUE", "were run",
    ("fleet-modes", "What became of the fleets"), "the number of items an hour", "items an hour",
    lambda value: mean(Interval(value), ""), lambda interval: mean(interval, "an hour"),
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


COSTS = ("steps", "seconds", "joules")
"""Costs of a delivery, compared where both cases deliver."""


class PairedCosts(NamedTuple):
    """Mean costs of two cases over the seeds that both deliver.

    The difference is the mean of the second minus the first, seed by seed.
    """

    first: float
    second: float
    difference: Interval


class PairedCases(NamedTuple):
    """Two cases over the seeds that both have, and which of these they deliver.

    Attributes:
        changes: the number of seeds with each pair of modes, of the first case and of the second.
        chance: the probability of a split at least as uneven if neither were better; McNemar's
            exact test, times the number of pairs to choose from (Bonferroni).
        costs: costs of the seeds that both delivered, by column; empty if there are none.
    """

    changes: dict[tuple[str, str], int]
    only_first: int
    only_second: int
    chance: float
    both: int
    costs: dict[str, PairedCosts]

    @property
    def seeds(self) -> int:
        """The number of seeds that both cases have."""
        return sum(self.changes.values())


def compare(store: Store, first: int, second: int, pairs_to_choose: int = 1) -> PairedCases:
    """Compare two cases, chosen by their results from so many pairs.

    Source: McNemar (1947), Note on the sampling error of the difference between correlated
    proportions or percentages.
    """
    from scipy.special import betainc  # here, because it takes long to import

    pairs = """
        FROM episodes a JOIN episodes b ON b.seed = a.seed WHERE a.case_id = ? AND b.case_id = ?
    """
    modes = store.query(
        f"SELECT a.mode, b.mode, count(*) {pairs} GROUP BY a.mode, b.mode", first, second
    )
    changes = {(mine, yours): count for mine, yours, count in modes}
    both = changes.get((DELIVERED, DELIVERED), 0)
    only_first = sum(count for (a, b), count in changes.items() if a == DELIVERED != b)
    only_second = sum(count for (a, b), count in changes.items() if a != DELIVERED == b)
    split = only_first + only_second
    names = ", ".join(f"a.{column}, b.{column}" for column in COSTS)
    rows = np.fromiter(
        store.query(
            f"SELECT {names} {pairs} AND a.mode = b.mode AND a.mode = ?", first, second, DELIVERED
        ),
        (float, 2 * len(COSTS)),
    )
    costs = {}
    for column, (one, other) in zip(COSTS, rows.T.reshape(len(COSTS), 2, -1), strict=True):
        if difference := mean_interval(other - one):
            costs[column] = PairedCosts(float(one.mean()), float(other.mean()), difference)
    fewer = min(only_first, only_second)
    chance = 2 * float(betainc(split - fewer, fewer + 1, 0.5)) if split else 1.0
    chance = min(pairs_to_choose * chance, 1.0)
    return PairedCases(changes, only_first, only_second, chance, both, costs)


def rate_difference(store: Store, first: int, second: int) -> Interval | None:
    """Return how many items an hour more a first fleet delivers, ``None`` without a common seed."""
    rows = store.query(
        "SELECT a.per_hour - b.per_hour FROM shifts a JOIN shifts b ON b.seed = a.seed "
        "WHERE a.case_id = ? AND b.case_id = ? "
        "AND a.per_hour IS NOT NULL AND b.per_hour IS NOT NULL",
        first,
        second,
    )
    return mean_interval(np.fromiter((value for (value,) in rows), dtype=float))
