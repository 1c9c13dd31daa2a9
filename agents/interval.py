"""Estimates with the 95% intervals that go with them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CONFIDENCE = 0.95

RESAMPLES = 999
"""Of a bootstrap; odd, so that the ends of the interval are resamples themselves."""

BATCH_VALUES = 2_000_000
"""Values that a bootstrap draws at once, so that many take little memory."""


class Interval(NamedTuple):
    """An estimate and the ends of its interval."""

    estimate: float
    low: float
    high: float


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
        values: ``[n]``; ``None`` comes of fewer than two, which have no interval.

    Source: Efron (1979), Bootstrap methods: another look at the jackknife.
    """
    from scipy.stats import bootstrap

    if len(values) < 2:
        return None
    # Single precision is twice as fast, and the sums of a bootstrap forgive it.
    found = bootstrap(
        (values - values.mean(),),
        np.mean,
        n_resamples=RESAMPLES,
        batch=max(1, BATCH_VALUES // len(values)),
        confidence_level=CONFIDENCE,
        method="percentile",
        vectorized=True,
        rng=np.random.default_rng(0),
    ).confidence_interval
    mean = float(values.mean())
    return Interval(mean, mean + float(found.low), mean + float(found.high))
