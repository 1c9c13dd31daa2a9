"""Two cases compared seed by seed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

from agents.experiments.store import Store
from agents.interval import Interval, mean_interval
from warehouse_core.episode import DELIVERED


class Comparison(NamedTuple):
    """Two cases over the seeds that both have.

    Attributes:
        changes: how many seeds came to each pair of modes, of the first case and of the second.
        only_first: how many were delivered by the first case and not by the second.
        only_second: how many were delivered by the second and not by the first.
        chance: the probability of so uneven a split if neither were better; McNemar's exact test.
        both: how many both delivered.
        first: mean steps of the first where both delivered, ``nan`` if there are none.
        second: those of the second.
        difference: of the second less the first, seed by seed.
    """

    changes: dict[tuple[str, str], int]
    only_first: int
    only_second: int
    chance: float
    both: int
    first: float
    second: float
    difference: Interval | None

    @property
    def seeds(self) -> int:
        """How many seeds both cases have."""
        return sum(self.changes.values())


def compare(store: Store, first: int, second: int) -> Comparison:
    """Compare two cases seed by seed.

    Source: McNemar (1947), Note on the sampling error of the difference between correlated
    proportions or percentages.
    """
    pairs = """
        FROM episodes a JOIN episodes b ON b.case_id = ?2 AND b.seed = a.seed WHERE a.case_id = ?1
    """
    modes = store.query(
        f"SELECT a.mode, b.mode, count(*) {pairs} GROUP BY a.mode, b.mode", first, second
    )
    changes = {(mine, yours): count for mine, yours, count in modes}
    only_first, only_second = (
        sum(
            count
            for pair, count in changes.items()
            if pair[own] == DELIVERED and pair[1 - own] != DELIVERED
        )
        for own in (0, 1)
    )
    split = only_first + only_second
    steps = np.fromiter(
        store.query(
            f"SELECT a.steps, b.steps {pairs} AND a.mode = ?3 AND b.mode = ?3",
            first, second, DELIVERED,
        ),
        (np.float32, 2),
    )  # fmt: skip
    return Comparison(
        changes,
        only_first,
        only_second,
        float(binomtest(only_first, split).pvalue) if split else 1.0,
        len(steps),
        float(steps[:, 0].mean()) if len(steps) else math.nan,
        float(steps[:, 1].mean()) if len(steps) else math.nan,
        mean_interval(steps[:, 1] - steps[:, 0]),
    )
