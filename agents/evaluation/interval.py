"""Estimates with the 95% intervals that go with them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

CONFIDENCE = 0.95

RESAMPLES = 999
"""Of a bootstrap."""

BATCH_VALUES = 2_000_000
"""Values that a bootstrap draws at once, so that many take little memory."""


FEW = 20
"""Values; the bootstrap of fewer makes intervals that are far too narrow."""


class Interval(NamedTuple):
    """An estimate and the ends of its interval, NaN where nothing can be said of them."""

    estimate: float
    low: float = math.nan
    high: float = math.nan

    @property
    def is_known(self) -> bool:
        """Whether there is more than the estimate."""
        return not math.isnan(self.low)


def share_interval(count: int, total: int) -> Interval:
    """Return Wilson's interval of a share.

    Args:
        count: of those that have it.
        total: of all, at least one.

    Source: Wilson (1927), Probable inference, the law of succession, and statistical inference.
    """
    from scipy.stats import binomtest

    found = binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return Interval(count / total, float(found.low), float(found.high))


def mean_interval(values: np.ndarray) -> Interval | None:
    """Return the percentile bootstrap's interval of a mean, the same one every time.

    Args:
        values: ``[n]``; of fewer than ``FEW`` there is a mean but no interval, of none ``None``.

    Source: Efron (1979), Bootstrap methods: another look at the jackknife.
    """
    from scipy.stats import bootstrap

    if not len(values):
        return None
    if len(values) < FEW:
        return Interval(float(values.astype(float).mean()))
    values = values.astype(float)
    mean = float(values.mean())
    # About the mean, so that large values lose no digits.
    found = bootstrap(
        (values - mean,),
        np.mean,
        n_resamples=RESAMPLES,
        batch=max(1, BATCH_VALUES // len(values)),
        confidence_level=CONFIDENCE,
        method="percentile",
        vectorized=True,
        rng=np.random.default_rng(0),
    ).confidence_interval
    return Interval(mean, mean + min(float(found.low), 0.0), mean + max(float(found.high), 0.0))
