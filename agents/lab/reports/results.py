"""The results of an experiment: how its cases differ, and measures with their intervals.

A *factor* is a parameter that has several values. The cases of a *series* differ in one factor and
in nothing else. A parameter that does not apply to a case, such as the memory of an agent without
memory, does not count as a difference. Two cases are compared seed by seed, because equal seeds are
equal tasks.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cache
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

Columns = dict[str, np.ndarray]
"""Fields of the rows of some cases, and the number of the case of each, ``[n]``."""

Labels = dict[str, Value | None]
"""Displayed values of a case by parameter; ``None`` where a parameter does not apply."""

CONTENTS = {"layout": TILES, "agent": FINGERPRINT, PLANNER: FINGERPRINT}
"""Parameters that may name files, and the keys of a case with the contents of the files."""

FOLDERS = re.compile(r"(\b[A-Za-z]:)?[^:]*[/\\]")
"""Pattern for the folders in the path of a file, which may follow a word and a colon."""

SIZE = re.compile(r"(\d+)x(\d+)")


class Factor(NamedTuple):
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


class Design:
    """The cases of an experiment, and the parameters that differ between them.

    Attributes:
        labels: Displayed values of each case, by the number of the case.
        factors: Parameters that differ, in the order of ``PARAMETERS``.
        fixed: Values of the other parameters.
    """

    def __init__(self, cases: Mapping[int, Case]) -> None:
        self.labels = _labels(cases)
        self.factors, self.fixed = list[Factor](), Labels()
        known = {name for labels in self.labels.values() for name in labels}
        for name in [*PARAMETERS, *sorted(known - PARAMETERS.keys())]:
            for labels in self.labels.values():
                labels.setdefault(name, None)
            found = dict.fromkeys(labels[name] for labels in self.labels.values())
            values = [value for value in found if value is not None]
            if len(values) > 1:
                self.factors.append(Factor(name, tuple(sorted(values, key=_rank))))
            elif values:
                self.fixed[name] = values[0]

    def series(self, factor: Factor) -> list[CaseSeries]:
        """Return every series of a factor, beginning with the one nearest to the defaults."""
        others = [each.name for each in self.factors if each != factor]
        groups: dict[tuple[Value | None, ...], dict[Value, int]] = {}
        for case_id, labels in self.labels.items():
            if (value := labels[factor.name]) is not None:
                groups.setdefault(tuple(labels[name] for name in others), {})[value] = case_id
        # A parameter that does not apply agrees with any value.
        partial, merged = [key for key in groups if None in key], set[tuple[Value | None, ...]]()
        series = []
        for key in groups:
            matching = [each for each in partial if each != key and _agree(each, key)]
            merged.update(each for each in matching if _is_part(each, key))
            cases = {
                value: case for each in [*matching, key] for value, case in groups[each].items()
            }
            series.append((key, {value: cases[value] for value in factor.values if value in cases}))
        found = [
            CaseSeries(dict(zip(others, key, strict=True)), cases)
            for key, cases in series
            if len(cases) > 1 and key not in merged
        ]
        return sorted(found, key=lambda each: -_defaults_in(each.others))

    def name_of(self, case_id: int) -> str:
        """Return the values of a case that differ between cases, in words."""
        return described({each.name: self.labels[case_id][each.name] for each in self.factors})


def described(labels: Mapping[str, Value | None]) -> str:
    """Return values as a list in words, such as ``battery 20, escape on``."""
    given = [f"{name} {shown(value)}" for name, value in labels.items() if value is not None]
    return ", ".join(given)


def _labels(cases: Mapping[int, Case]) -> dict[int, Labels]:
    """Return the displayed values of each case, with files named without their folders.

    Files that have the same name and different contents are different versions.
    """
    versions: dict[tuple[str, str], list[Any]] = {}
    found: dict[int, Labels] = {}
    for case_id, case in cases.items():
        found[case_id] = labels = {k: v for k, v in case.items() if k not in (TILES, FINGERPRINT)}
        for name in CONTENTS.keys() & case.keys():
            short = FOLDERS.sub("", case[name]) or case[name]
            contents, content = versions.setdefault((name, short), []), case.get(CONTENTS[name])
            if content not in contents:
                contents.append(content)
            version = contents.index(content) + 1
            labels[name] = short if version == 1 else f"{short} (version {version})"
    _name_stations_with_layouts(found.values())
    return found


def _name_stations_with_layouts(labels: Collection[Labels]) -> None:
    """Merge stations into the layout if they differ between layouts, but not within any layout.

    This is common, because by default the stations of a layout file are kept, and other stations
    are random. Layout and stations are then one factor instead of two.
    """
    pairs = {(each["layout"], each.get("stations")) for each in labels}
    layouts, stations = map(set, zip(*pairs, strict=True)) if pairs else ((), ())
    if len(pairs) == len(layouts) and len(stations) > 1:
        for each in labels:
            each["layout"] = f"{each['layout']} (stations {each.pop('stations')})"


def _rank(value: Value) -> Any:
    """Return a sort key for a value: on before off, sizes by area, names in their given order."""
    if isinstance(value, str):
        size = SIZE.fullmatch(value)
        return int(size[1]) * int(size[2]) if size else 0
    return not value if isinstance(value, bool) else value


def _agree(combination: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Return whether two combinations are equal wherever both have a value."""
    return all(
        one == two or None in (one, two) for one, two in zip(combination, other, strict=True)
    )


def _is_part(combination: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Return whether a combination equals another one with some values left out."""
    return all(one in (None, two) for one, two in zip(combination, other, strict=True))


def _defaults_in(labels: Labels) -> int:
    return sum(value is not None and find(name).default == value for name, value in labels.items())


class ReportedMeasure(NamedTuple):
    """A measure that reports show in the table, in a chart and in sentences.

    Attributes:
        name: Name of its picture and of its column in the table.
        title: Title of its chart, and its name in verdicts.
        says: Beginning of a sentence that ends with values, such as ``"a delivery takes"``.
        unit: Unit, or ``"%"`` for a share.
        value: Function of columns that returns its values, which are NaN where there is none.
        what: Definition of the measure, for the caption.
        is_physical: True if only backends that simulate time and energy measure it.
    """

    name: str
    title: str
    says: str
    unit: str
    value: Callable[[Columns], np.ndarray]
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
        if self.unit != "%":
            return mean(abs(difference), f"{self.unit} {more}")
        return mean(abs(Interval(*(100 * each for each in difference))), f"points {more}")


def _of_deliveries(name: str, title: str, verb: str, unit: str) -> ReportedMeasure:
    return ReportedMeasure(
        name, f"{title} of a delivery", f"a delivery {verb}", unit,
        lambda each: np.where(each["mode"] == DELIVERED, each[name], np.nan),
        "mean over all deliveries, hard or easy", name != "steps",
    )  # fmt: skip


def _blocked(each: Columns) -> np.ndarray:
    stopped = each["blocked_by_wall"] + each["blocked_by_robot"] + each["blocked_by_person"]
    with np.errstate(invalid="ignore"):  # NaN without any move
        share: np.ndarray = each["blocked_by_robot"] / (each["distance"] + stopped)
    return share


SUCCESS = ReportedMeasure(
    "success", "Success", "success is", "%",
    lambda each: (each["mode"] == DELIVERED).astype(float), "share of all episodes",
)  # fmt: skip
STEPS = _of_deliveries("steps", "Steps", "takes", "steps")
SECONDS = _of_deliveries("seconds", "Time", "takes", "s")
JOULES = _of_deliveries("joules", "Energy", "uses", "J")

PER_HOUR = ReportedMeasure(
    "per_hour", "Rate of deliveries", "the rate of deliveries is", "per hour",
    lambda each: np.nan_to_num(each["per_hour"]),
)  # fmt: skip
ON_TIME = ReportedMeasure(
    "on_time", "Share on time", "the share on time is", "%", lambda each: each["on_time"]
)
LATENESS = ReportedMeasure(
    "lateness", "Lateness of a delivery", "the lateness of a delivery is", "steps",
    lambda each: each["mean_lateness"],
)  # fmt: skip
ENERGY = ReportedMeasure(
    "energy", "Energy of a delivery", "a delivery uses", "kJ",
    lambda each: each["joules_per_delivery"] / 1000, "energy of all robots, mean of all episodes",
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


class Results:
    """The pooled results of some cases.

    Attributes:
        columns: Fields of the rows, ``[n]``, and the case of each, in the order of cases and seeds.
        episodes: Number of episodes.
        modes: Number of episodes with each mode that occurs, in the order of ``MODES_OF``.
        seeds: First seed and last seed.
        is_measured: True if seconds and joules are measured; on the grid they are nominal.
        interval: Function that computes the interval of a measure once.
    """

    def __init__(self, experiment: Experiment, case_ids: CaseIds) -> None:
        self.kind, self.case_ids = experiment.kind, case_ids
        parts = [experiment.columns[each] for each in case_ids]
        self.columns = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
        modes = Counter(self.columns["mode"].tolist())
        self.episodes = modes.total()
        self.modes = {mode: modes[mode] for mode in MODES_OF[self.kind.row] if mode in modes}
        self.seeds = int(self.columns["seed"].min()), int(self.columns["seed"].max())
        self.is_measured = all(experiment.cases[each]["backend"] != "grid" for each in case_ids)
        self.interval = cache(self._interval)

    def has(self, measure: ReportedMeasure) -> bool:
        """Return whether these cases measure it, instead of assuming a nominal value."""
        return self.is_measured or not measure.is_physical

    def _interval(self, measure: ReportedMeasure) -> Interval | None:
        """Return the mean or the share of a measure, or ``None`` if no episode has a value."""
        values = measure.value(self.columns)
        if measure is SUCCESS:
            return share_interval(int(values.sum()), len(values))
        return mean_interval(values[~np.isnan(values)])

    @property
    def main(self) -> Interval:
        """Interval of the measure by which values are compared."""
        interval = self.interval(self.kind.measures[0])
        assert interval is not None, "every case with episodes has it"
        return interval


class Experiment:
    """The cases of one kind in a file of results, and their results, each computed once.

    Attributes:
        path: File of results.
        cases: Cases with episodes, by their numbers.
        columns: Fields of the rows of these cases, see ``Results``.
        unbegun: Number of cases of this kind without an episode.
        design: Differences between the cases.
        results, paired: Functions that compute pooled results and comparisons once.

    Raises:
        StoreError: no sweep can have written one of the cases or rows.
    """

    def __init__(self, store: Store, kind: ReportKind) -> None:
        self.path, self.kind = store.path, kind
        found = {n: case for n, case in store.cases().items() if row_type(case) is kind.row}
        columns = {number: _columns(number, store.rows(number, kind.row)) for number in found}
        self.columns = {number: each for number, each in columns.items() if each}
        self.cases = {number: found[number] for number in self.columns}
        self.unbegun, self.design = len(found) - len(self.cases), Design(self.cases)
        self.results, self.paired = cache(self._results), cache(self._paired)

    def _results(self, *case_ids: int) -> Results:
        """Return the pooled results of some cases."""
        return Results(self, case_ids)

    def _paired(self, measure: ReportedMeasure, one: int, other: int) -> Interval | None:
        """Return how much larger a measure is in one case than in another, compared seed by seed.

        Only seeds for which both cases have a value are compared. Return ``None`` if there are no
        such seeds.
        """
        first, second = self.columns[one], self.columns[other]
        _, *both = np.intersect1d(
            first["seed"], second["seed"], assume_unique=True, return_indices=True
        )
        values = measure.value(first)[both[0]] - measure.value(second)[both[1]]
        values = values[~np.isnan(values)]
        if measure is SUCCESS and len(values):
            return paired_share_interval(np.sum(values > 0), np.sum(values < 0), len(values))
        return mean_interval(values)


def _columns(case_id: int, rows: Iterable[AnyRow]) -> Columns:
    """Return the fields of the rows of a case as arrays; ``None`` is NaN. No row has no columns."""
    found = list(rows)
    if not found:
        return {}
    columns = {
        name: np.array(each)
        for name, each in zip(found[0]._fields, zip(*found, strict=True), strict=True)
    }
    columns["case"] = np.full(len(found), case_id)
    return {n: each.astype(float) if each.dtype == object else each for n, each in columns.items()}
