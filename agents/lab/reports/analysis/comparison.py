"""Two cases compared seed by seed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.lab.experiments.store import Store
from agents.lab.trials.interval import Interval, mean_interval
from warehouse_core.records.episode import DELIVERED

COLUMNS = ("steps", "seconds", "joules")
"""Costs of a delivery, compared where both cases deliver."""


class PairedCosts(NamedTuple):
    """Mean costs of two cases over the seeds that both deliver.

    The difference is the mean of the second minus the first, seed by seed.
    """

    first: float
    second: float
    difference: Interval


class Comparison(NamedTuple):
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


def compare(store: Store, first: int, second: int, pairs_to_choose: int = 1) -> Comparison:
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
    names = ", ".join(f"a.{column}, b.{column}" for column in COLUMNS)
    rows = np.fromiter(
        store.query(
            f"SELECT {names} {pairs} AND a.mode = b.mode AND a.mode = ?", first, second, DELIVERED
        ),
        (float, 2 * len(COLUMNS)),
    )
    costs = {}
    for column, (one, other) in zip(COLUMNS, rows.T.reshape(len(COLUMNS), 2, -1), strict=True):
        if difference := mean_interval(other - one):
            costs[column] = PairedCosts(float(one.mean()), float(other.mean()), difference)
    fewer = min(only_first, only_second)
    chance = 2 * float(betainc(split - fewer, fewer + 1, 0.5)) if split else 1.0
    chance = min(pairs_to_choose * chance, 1.0)
    return Comparison(changes, only_first, only_second, chance, both, costs)
