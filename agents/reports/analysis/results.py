"""Counts, shares and means of the episodes of some cases, with their intervals."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from agents.errors import StoreError
from agents.evaluation.interval import Interval, mean_interval, share_interval
from agents.experiments.case import Case
from agents.experiments.store import Store
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import MODES

CaseIds = tuple[int, ...]


class Tally(NamedTuple):
    """The number of episodes of a case with one mode, and their first and last seeds."""

    mode: str
    episodes: int
    first_seed: int
    last_seed: int


class Experiment:
    """The cases of a file of results that have episodes, and their results, computed once.

    Args:
        store: the file.

    Attributes:
        cases: those with episodes, by their numbers.
        unbegun: how many cases have no episode yet.

    Raises:
        StoreError: there is no episode in it, it is damaged, or it cannot be read.
    """

    def __init__(self, store: Store) -> None:
        self.store = store
        store.check_rows()
        self._tallies: dict[int, list[Tally]] = {}
        for case_id, *tally in store.query(
            "SELECT case_id, mode, count(*), min(seed), max(seed) FROM episodes "
            "GROUP BY case_id, mode"
        ):
            self._tallies.setdefault(case_id, []).append(Tally(*tally))
        if not self._tallies:
            raise StoreError(f"{store.path}: there is no episode in it")
        cases = store.cases()
        self.cases: dict[int, Case] = {case_id: cases[case_id] for case_id in self._tallies}
        self.unbegun = len(cases) - len(self.cases)
        self._results: dict[CaseIds, Results] = {}

    def results(self, *case_ids: int) -> Results:
        """Return the results of some cases, pooled."""
        found = [tally for case_id in case_ids for tally in self._tallies[case_id]]
        modes = Counter[str]()
        for tally in found:
            modes[tally.mode] += tally.episodes
        seeds = min(each.first_seed for each in found), max(each.last_seed for each in found)
        return self._results.setdefault(
            case_ids,
            Results(
                self.store,
                case_ids,
                {mode: modes[mode] for mode in MODES if mode in modes},
                seeds,
                all(self.cases[case_id]["backend"] != "grid" for case_id in case_ids),
            ),
        )


@dataclass(frozen=True, eq=False)
class Results:
    """The episodes of some cases, read when they are needed.

    Attributes:
        store: where they are.
        case_ids: of the cases.
        modes: the number of episodes with each mode that occurs, in the order of ``MODES``.
        seeds: the first and the last.
        is_measured: whether seconds and joules are measured; those of the grid are nominal.
    """

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
    def delivered(self) -> int:
        """The number of deliveries."""
        return self.modes.get(DELIVERED, 0)

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
        return mean_interval(self._values("steps"))

    @cached_property
    def needed(self) -> float | None:
        """The mean steps of the shortest ways of the deliveries."""
        values = self._values("needed")
        return float(values.mean()) if len(values) else None

    @cached_property
    def seconds(self) -> Interval | None:
        """The mean simulated time of a delivery, in s."""
        return mean_interval(self._values("seconds"))

    @cached_property
    def joules(self) -> Interval | None:
        """The mean energy of a delivery, in J."""
        return mean_interval(self._values("joules"))

    def _values(self, column: str) -> np.ndarray:
        """Return a column of the deliveries, ``[n]``."""
        statement = f"SELECT {column} FROM episodes WHERE case_id = ? AND mode = ?"
        return np.concatenate(
            [
                np.fromiter(
                    (value for (value,) in self.store.query(statement, case_id, DELIVERED)),
                    dtype=float,
                )
                for case_id in self.case_ids
            ]
        )
