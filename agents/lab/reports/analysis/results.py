"""Counts, shares and means of the episodes of some cases, with their intervals."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Generic, NamedTuple, TypeVar

import numpy as np

from agents.lab.evaluation.interval import Interval, mean_interval, share_interval
from agents.lab.experiments.case import Case, row_type
from agents.lab.experiments.store import Store
from agents.lab.experiments.tables import TABLE_OF, AnyRow, Row, Shift
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import FLEET_MODES, MODES

CaseIds = tuple[int, ...]


class Tally(NamedTuple):
    """The number of episodes of a case with one mode, and their first and last seeds."""

    mode: str
    episodes: int
    first_seed: int
    last_seed: int


@dataclass(frozen=True, eq=False)
class Results:
    """The episodes of some cases, read when they are needed.

    Attributes:
        kind: of the rows.
        all_modes: that an episode can have, in order.
        counts: what a mean is taken over, in words.
        store: where they are.
        case_ids: of the cases.
        modes: the number of episodes with each mode that occurs, in the order of ``all_modes``.
        seeds: the first and the last.
        is_measured: whether seconds and joules are measured; those of the grid are nominal.
    """

    kind: ClassVar[type[AnyRow]]
    all_modes: ClassVar[tuple[str, ...]]
    counts: ClassVar[str]

    store: Store
    case_ids: CaseIds
    modes: dict[str, int]
    seeds: tuple[int, int]
    is_measured: bool

    @cached_property
    def episodes(self) -> int:
        """The number of episodes."""
        return sum(self.modes.values())

    @property
    def count(self) -> int:
        """What a mean is taken over, their number."""
        return self.episodes

    def _values(self, column: str, condition: str) -> np.ndarray:
        """Return a column of the rows that meet a condition, ``[n]``."""
        statement = f"SELECT {column} FROM {TABLE_OF[self.kind]} WHERE case_id = ? AND {condition}"
        found = [
            np.fromiter((value for (value,) in self.store.query(statement, case_id)), dtype=float)
            for case_id in self.case_ids
        ]
        return np.concatenate(found)


class Deliveries(Results):
    """The episodes of lone robots."""

    kind, all_modes, counts = Row, MODES, "were delivered"

    @property
    def delivered(self) -> int:
        """The number of deliveries."""
        return self.modes.get(DELIVERED, 0)

    @property
    def count(self) -> int:
        """The number of deliveries."""
        return self.delivered

    @property
    def share(self) -> float:
        """The share that was delivered."""
        return self.delivered / self.episodes

    @cached_property
    def success(self) -> Interval:
        """The share that was delivered, with its interval."""
        return share_interval(self.delivered, self.episodes)

    @cached_property
    def steps(self) -> Interval | None:
        """The mean steps of a delivery."""
        return mean_interval(self._delivered("steps"))

    @cached_property
    def needed(self) -> float | None:
        """The mean steps of the shortest ways of the deliveries."""
        values = self._delivered("needed")
        return float(values.mean()) if len(values) else None

    @cached_property
    def seconds(self) -> Interval | None:
        """The mean simulated time of a delivery, in s."""
        return mean_interval(self._delivered("seconds"))

    @cached_property
    def joules(self) -> Interval | None:
        """The mean energy of a delivery, in J."""
        return mean_interval(self._delivered("joules"))

    def _delivered(self, column: str) -> np.ndarray:
        return self._values(column, f"mode = '{DELIVERED}'")


class Shifts(Results):
    """The episodes of fleets; a measure is a mean over those that have it."""

    kind, all_modes, counts = Shift, FLEET_MODES, "were run"

    @cached_property
    def per_hour(self) -> Interval:
        """The mean number of items delivered in an hour."""
        return self._mean("per_hour") or Interval(0.0)

    @cached_property
    def on_time(self) -> Interval | None:
        """The mean share of the deliveries that were on time."""
        return self._mean("on_time")

    @cached_property
    def lateness(self) -> Interval | None:
        """The mean of the mean lateness, in steps."""
        return self._mean("mean_lateness")

    @cached_property
    def energy(self) -> Interval | None:
        """The mean energy of a delivery, in kJ."""
        return self._mean("joules_per_delivery / 1000")

    @cached_property
    def blocked(self) -> Interval | None:
        """The mean share of the moves that other robots blocked."""
        blocked = "blocked_by_wall + blocked_by_robot + blocked_by_person"
        return self._mean(f"blocked_by_robot * 1.0 / nullif(distance + {blocked}, 0)")

    def _mean(self, column: str) -> Interval | None:
        return mean_interval(self._values(column, f"{column} IS NOT NULL"))


AnyResults = TypeVar("AnyResults", bound=Results)


class Experiment(Generic[AnyResults]):
    """The cases of a file of results with episodes of one kind, and their results, computed once.

    Args:
        store: the file.
        results_type: ``Deliveries`` or ``Shifts``.

    Attributes:
        cases: those with episodes, by their numbers.
        unbegun: how many cases of this kind have no episode yet.

    Raises:
        StoreError: it is damaged, or it cannot be read.
    """

    def __init__(self, store: Store, results_type: type[AnyResults]) -> None:
        self.store, self._type = store, results_type
        store.check_rows()
        self._tallies: dict[int, list[Tally]] = {}
        if results_type.kind in store.kinds:
            for case_id, *tally in store.query(
                "SELECT case_id, mode, count(*), min(seed), max(seed) "
                f"FROM {TABLE_OF[results_type.kind]} GROUP BY case_id, mode"
            ):
                self._tallies.setdefault(case_id, []).append(Tally(*tally))
        cases = store.cases()
        self.cases: dict[int, Case] = {case_id: cases[case_id] for case_id in self._tallies}
        kind = results_type.kind
        self.unbegun = sum(row_type(case) is kind for case in cases.values()) - len(self.cases)
        self._results: dict[CaseIds, AnyResults] = {}

    def results(self, *case_ids: int) -> AnyResults:
        """Return the results of some cases, pooled."""
        found = [tally for case_id in case_ids for tally in self._tallies[case_id]]
        modes = Counter[str]()
        for tally in found:
            modes[tally.mode] += tally.episodes
        seeds = min(each.first_seed for each in found), max(each.last_seed for each in found)
        return self._results.setdefault(
            case_ids,
            self._type(
                self.store,
                case_ids,
                {mode: modes[mode] for mode in self._type.all_modes if mode in modes},
                seeds,
                all(self.cases[case_id]["backend"] != "grid" for case_id in case_ids),
            ),
        )
