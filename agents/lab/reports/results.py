"""The results of an experiment: how its cases differ, and measures with their intervals.

A *factor* is a parameter that has several values. The cases of a *series* differ in one factor and
in nothing else. A parameter that does not apply to a case, such as the memory of an agent without
memory, does not count as a difference. Two cases are compared seed by seed, because equal seeds are
equal tasks.
"""

from __future__ import annotations

import hashlib
import math
import operator
import re
from array import array
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from typing import Any, NamedTuple

import numpy as np

from agents.lab.experiments.case import FINGERPRINT, TILES, Case, row_type
from agents.lab.experiments.store import Store
from agents.lab.parameters import PARAMETERS, PLANNER, Value, find, shown
from agents.lab.trials.interval import (
    Interval,
    mean,
    mean_interval,
    paired_share_interval,
    percent,
    share,
    share_interval,
)
from agents.lab.trials.rows import MODES_OF, AnyRow, FleetRow, Row
from warehouse_core.records.episode import DELIVERED

CaseIds = tuple[int, ...]

Labels = dict[str, Value | None]
"""Displayed values of a case by parameter; ``None`` where a parameter does not apply."""

FOLDERS = re.compile(r"(\b[A-Za-z]:)?[^:]*[/\\]")
"""Pattern for the folders in the path of a file, which may follow a word and a colon."""

Combination = tuple[Value | None, ...]
"""Values of some factors, in the order of the factors."""

MARK_LENGTH = 6
"""Number of digits of a digest that distinguish two files with the same name."""


@dataclass(frozen=True, slots=True)
class Factor:
    """A parameter that differs, with its values in the order in which they are displayed."""

    name: str
    values: tuple[Value, ...]

    @property
    def is_numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(type(value) in (int, float) for value in self.values)

    @property
    def is_ordered(self) -> bool:
        """Whether the values have an order."""
        return self.is_numeric or self.name == "size"


class CaseSeries(NamedTuple):
    """Cases that differ in one factor alone.

    Attributes:
        others: Values of the other factors.
        cases: Numbers of the cases by their values of the factor.
    """

    others: Labels
    cases: dict[Value, int]


@dataclass(frozen=True)
class Design:
    """The cases of an experiment, and the parameters that differ between them.

    Attributes:
        labels: Displayed values of each case, by the number of the case.
        factors: Parameters that differ, in the order of ``PARAMETERS``.
        fixed: Values of the other parameters.
    """

    labels: dict[int, Labels]
    factors: tuple[Factor, ...]
    fixed: Labels

    def series(self, factor: Factor) -> list[CaseSeries]:
        """Return every series of a factor, beginning with the one nearest to the defaults."""
        others = [each.name for each in self.factors if each != factor]
        exact: dict[Combination, list[int]] = {}
        for case_id, labels in self.labels.items():
            exact.setdefault(tuple(labels[name] for name in others), []).append(case_id)
        series = []
        for combination, comparable in _comparable(exact).items():
            cases = {
                value: case_id
                for each in comparable
                for case_id in exact[each]
                if (value := self.labels[case_id][factor.name]) is not None
            }
            if len(cases) > 1:
                labels = dict(zip(others, combination, strict=True))
                series.append(
                    CaseSeries(labels, {v: cases[v] for v in factor.values if v in cases})
                )
        return sorted(series, key=lambda each: -_defaults_in(each.others))

    def name_of(self, case_id: int) -> str:
        """Return the values of a case that differ between cases, in words."""
        return described({each.name: self.labels[case_id][each.name] for each in self.factors})


def make_design(cases: Mapping[int, Case]) -> Design:
    """Return the design of an experiment, given its cases by number."""
    labels = _labels(cases)
    known = {name for each in labels.values() for name in each}
    names = [*PARAMETERS, *sorted(known - PARAMETERS.keys())]
    factors, fixed = [], Labels()
    for name in names:
        values = dict.fromkeys(each.get(name) for each in labels.values())
        for each in labels.values():
            each.setdefault(name, None)
        shown = [value for value in values if value is not None]
        if len(shown) > 1:
            factors.append(Factor(name, tuple(sorted(shown, key=_rank))))
        elif shown:
            fixed[name] = shown[0]
    return Design(labels, tuple(factors), fixed)


def described(labels: Mapping[str, Value | None]) -> str:
    """Return values as a list in words, such as ``battery 20, escape on``."""
    given = [f"{name} {shown(value)}" for name, value in labels.items() if value is not None]
    return ", ".join(given)


def _labels(cases: Mapping[int, Case]) -> dict[int, Labels]:
    """Return the displayed values of each case, with files named without their folders.

    Files that have the same name and different contents are marked with a digest.
    """
    contents = {"layout": TILES, "agent": FINGERPRINT, PLANNER: FINGERPRINT}
    found = {
        case_id: {k: v for k, v in case.items() if k not in (TILES, FINGERPRINT)}
        for case_id, case in cases.items()
    }
    for name, content in contents.items():
        having = {case_id: case for case_id, case in cases.items() if name in case}
        short = {each: FOLDERS.sub("", case[name]) or case[name] for each, case in having.items()}
        files = {(short[each], str(case.get(content))) for each, case in having.items()}
        versions = Counter(file for file, _ in files)
        for case_id, case in having.items():
            found[case_id][name] = short[case_id]
            if versions[short[case_id]] > 1:
                digest = hashlib.sha256(repr(case.get(content)).encode()).hexdigest()
                found[case_id][name] += f" ({digest[:MARK_LENGTH]})"
    _name_stations_with_layouts(found.values())
    return found


def _name_stations_with_layouts(labels: Collection[Labels]) -> None:
    """Merge stations into the layout if they differ between layouts, but not within any layout.

    This is common, because by default the stations of a layout file are kept, and other stations
    are random. Layout and stations are then one factor instead of two.
    """
    pairs = {(each["layout"], each.get("stations")) for each in labels}
    layouts, stations = ({each[place] for each in pairs} for place in (0, 1))
    if len(pairs) == len(layouts) and len(stations) > 1:
        for each in labels:
            each["layout"] = f"{each['layout']} (stations {each.pop('stations')})"


def _rank(value: Value) -> tuple[object, ...]:
    """Return a sort key for a value: on before off, sizes by area, names in their given order."""
    if isinstance(value, bool):
        return (0, not value)
    if isinstance(value, str):
        height, x, width = value.partition("x")
        is_size = x and height.isdecimal() and width.isdecimal()
        return (1, int(height) * int(width)) if is_size else (2, 0)
    return (1, value)


def _comparable(
    combinations: Collection[Combination],
) -> dict[Combination, list[Combination]]:
    """Return the combinations that are comparable with each combination, and last itself.

    Two combinations are comparable if they are equal wherever both have a value. A combination
    that equals another one with some values left out is not among the keys.
    """
    groups: dict[tuple[bool, ...], list[Combination]] = {}
    for each in combinations:
        groups.setdefault(tuple(value is not None for value in each), []).append(each)
    found: dict[Combination, list[Combination]] = {each: [] for each in combinations}
    for own, members in groups.items():
        for mask, others in groups.items():
            both = tuple(map(operator.and_, own, mask))
            index: dict[Combination, list[Combination]] = {}
            for other in others:
                index.setdefault(tuple(compress(other, both)), []).append(other)
            for each in members:
                equal = index.get(tuple(compress(each, both)), [])
                if equal and own == both != mask:
                    found.pop(each, None)
                elif each in found:
                    found[each] += [other for other in equal if other != each]
    # The combination itself is last, so that no case with fewer values replaces its case.
    return {each: [*others, each] for each, others in found.items()}


def _defaults_in(labels: Labels) -> int:
    return sum(value is not None and find(name).default == value for name, value in labels.items())


class ReportedMeasure(NamedTuple):
    """A measure that reports show in the table, in a chart and in sentences.

    Attributes:
        name: Name of its picture and of its column in the table.
        title: Title of its chart, and its name in verdicts.
        says: Beginning of a sentence that ends with values, such as ``"a delivery takes"``.
        unit: Unit, or ``"%"`` for a share.
        value: Function that returns its value in an episode, or ``None`` if it has none.
        what: Definition of the measure, for the caption.
        is_physical: True if only backends that simulate time and energy measure it.
    """

    name: str
    title: str
    says: str
    unit: str
    value: Callable[[Any], float | None]
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
    name: str, title: str, says: str, unit: str, *, is_physical: bool = True
) -> ReportedMeasure:
    def value(row: Row) -> float | None:
        return getattr(row, name) if row.mode == DELIVERED else None

    what = "mean over all deliveries, hard or easy"
    return ReportedMeasure(name, title, says, unit, value, what, is_physical)


def _blocked(row: FleetRow) -> float | None:
    stopped = row.blocked_by_wall + row.blocked_by_robot + row.blocked_by_person
    moves = row.distance + stopped
    return row.blocked_by_robot / moves if moves else None


def _kilojoules(row: FleetRow) -> float | None:
    joules = row.joules_per_delivery
    return None if joules is None else joules / 1000


SUCCESS = ReportedMeasure(
    "success", "Success", "success is", "%", lambda row: row.mode == DELIVERED,
    what="share of all episodes",
)  # fmt: skip
STEPS = _of_deliveries(
    "steps", "Steps of a delivery", "a delivery takes", "steps", is_physical=False
)
SECONDS = _of_deliveries("seconds", "Time of a delivery", "a delivery takes", "s")
JOULES = _of_deliveries("joules", "Energy of a delivery", "a delivery uses", "J")

PER_HOUR = ReportedMeasure(
    "per_hour", "Rate of deliveries", "the rate of deliveries is", "per hour",
    lambda row: row.per_hour or 0.0,
)  # fmt: skip
ON_TIME = ReportedMeasure(
    "on_time", "Share on time", "the share on time is", "%", lambda row: row.on_time
)
LATENESS = ReportedMeasure(
    "lateness", "Lateness of a delivery", "the lateness of a delivery is", "steps",
    lambda row: row.mean_lateness,
)  # fmt: skip
ENERGY = ReportedMeasure(
    "energy", "Energy of a delivery", "a delivery uses", "kJ", _kilojoules,
    what="energy of all robots, mean of all episodes",
)  # fmt: skip
BLOCKED = ReportedMeasure(
    "blocked", "Share of moves that robots blocked", "the share of moves that robots blocked is",
    "%", _blocked,
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


class CaseEpisodes:
    """What reports need of the episodes of a case, which may be millions.

    Attributes:
        seeds: Seeds in ascending order, ``[n]``.
        values: Values of each measure, ``[n]``, which are NaN where an episode has none.
        modes: Number of episodes with each outcome.
        ends: Number of episodes of a lone robot with each outcome, row and column of the end.
        shortest: Steps and seed of the first of the shortest episodes with each outcome.
    """

    def __init__(self, kind: ReportKind, rows: Iterable[AnyRow]) -> None:
        self.modes, self.ends = Counter[str](), Counter[tuple[str, int, int]]()
        self.shortest: dict[str, tuple[int, int]] = {}
        seeds, columns = array("q"), {measure: array("d") for measure in kind.measures}
        for row in rows:
            seeds.append(row.seed)
            for measure, column in columns.items():
                value = measure.value(row)
                column.append(math.nan if value is None else value)
            self.modes[row.mode] += 1
            if row.mode not in self.shortest or row.steps < self.shortest[row.mode][0]:
                self.shortest[row.mode] = row.steps, row.seed
            if isinstance(row, Row):
                self.ends[row.mode, row.row, row.col] += 1
        self.seeds = np.array(seeds)
        self.values = {measure: np.array(column) for measure, column in columns.items()}


class Results:
    """The pooled results of some cases.

    Attributes:
        episodes: Number of episodes.
        modes: Number of episodes with each mode that occurs, in the order of ``MODES_OF``.
        seeds: First seed and last seed.
        is_measured: True if seconds and joules are measured; on the grid they are nominal.
    """

    def __init__(self, experiment: Experiment, case_ids: CaseIds) -> None:
        self.kind, self.case_ids = experiment.kind, case_ids
        self._episodes = [experiment.episodes[each] for each in case_ids]
        modes = sum((each.modes for each in self._episodes), Counter[str]())
        self.episodes = modes.total()
        self.modes = {mode: modes[mode] for mode in MODES_OF[self.kind.row] if mode in modes}
        ends = [int(each.seeds[end]) for each in self._episodes for end in (0, -1)]
        self.seeds = min(ends), max(ends)
        self.is_measured = all(experiment.cases[each]["backend"] != "grid" for each in case_ids)
        self._intervals: dict[ReportedMeasure, Interval | None] = {}

    def has(self, measure: ReportedMeasure) -> bool:
        """Return whether these cases measure it, instead of assuming a nominal value."""
        return self.is_measured or not measure.is_physical

    def interval(self, measure: ReportedMeasure) -> Interval | None:
        """Return the mean or the share of a measure, or ``None`` if no episode has a value."""
        if measure not in self._intervals:
            values = np.concatenate([each.values[measure] for each in self._episodes])
            self._intervals[measure] = (
                share_interval(int(values.sum()), len(values))
                if measure is SUCCESS
                else mean_interval(values[~np.isnan(values)])
            )
        return self._intervals[measure]

    @property
    def main(self) -> Interval:
        """Interval of the measure by which values are compared."""
        interval = self.interval(self.kind.measures[0])
        assert interval is not None, "every case with episodes has it"
        return interval


class Experiment:
    """The cases of one kind in a file of results, and their results, each computed once.

    Attributes:
        cases: Cases with episodes, by their numbers.
        episodes: Episodes of these cases.
        unbegun: Number of cases of this kind without an episode.

    Raises:
        StoreError: no sweep can have written one of the cases or rows.
    """

    def __init__(self, store: Store, kind: ReportKind) -> None:
        self.store, self.kind = store, kind
        self.cases, self.episodes = dict[int, Case](), dict[int, CaseEpisodes]()
        self.unbegun = 0
        for number, case in store.cases().items():
            if row_type(case) is kind.row:
                found = CaseEpisodes(kind, store.rows(number, kind.row))
                if found.modes:
                    self.cases[number], self.episodes[number] = case, found
                else:
                    self.unbegun += 1
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
            first, second = self.episodes[one], self.episodes[other]
            _, *both = np.intersect1d(
                first.seeds, second.seeds, assume_unique=True, return_indices=True
            )
            values = first.values[measure][both[0]] - second.values[measure][both[1]]
            self._paired[key] = _difference(measure, values[~np.isnan(values)])
        return self._paired[key]


def _difference(measure: ReportedMeasure, values: np.ndarray) -> Interval | None:
    """Return the interval of the mean of some differences."""
    if measure is SUCCESS and len(values):
        return paired_share_interval(int((values > 0).sum()), int((values < 0).sum()), len(values))
    return mean_interval(values)
