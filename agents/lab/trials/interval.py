"""Estimates with their 95% intervals, and their texts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

CONFIDENCE, RESAMPLES = 0.95, 999

QUANTILE = 1.959963984540054
"""Half the width of a normal confidence interval, in standard errors."""

BATCH_VALUES = 2_000_000
"""Maximum number of values that a bootstrap draws at once, which limits its memory."""

MIN_VALUES = 20
"""Minimum number of values for a bootstrap; with fewer, its intervals are far too narrow."""


class Interval(NamedTuple):
    """An estimate and the ends of its interval, which are NaN if they are unknown."""

    estimate: float
    low: float = math.nan
    high: float = math.nan

    @property
    def is_known(self) -> bool:
        """Whether the ends are known."""
        return not math.isnan(self.low)

    def __abs__(self) -> Interval:
        """Return the interval of the absolute value, if the whole interval is on one side of 0."""
        return Interval(abs(self.estimate), *sorted((abs(self.low), abs(self.high))))


def share_interval(count: int, total: int) -> Interval:
    """Return the Wilson interval of the share ``count / total``, where ``total`` is at least 1.

    Source: Wilson (1927), Probable inference, the law of succession, and statistical inference.
    """
    share, square = count / total, QUANTILE**2
    middle = (2 * total * share + square) / (2 * (total + square))
    spread = math.sqrt(4 * total * share * (1 - share) + square)
    half = QUANTILE / (2 * (total + square)) * spread
    return Interval(share, middle - half if count else 0.0, middle + half if count < total else 1.0)


def paired_share_interval(more: int, fewer: int, total: int) -> Interval:
    """Return the interval of the difference between two success rates over the same trials.

    Args:
        more: number of trials in which only the first succeeds.
        fewer: number of trials in which only the second succeeds.
        total: number of all trials.

    Source: Bonett and Price (2012), Adjusted Wald confidence interval for a difference of binomial
    proportions based on paired data.
    """
    first, second = (more + 1) / (total + 2), (fewer + 1) / (total + 2)
    middle = first - second
    half = QUANTILE * math.sqrt((first + second - middle**2) / (total + 2))
    return Interval((more - fewer) / total, max(middle - half, -1.0), min(middle + half, 1.0))


def difference_interval(one: Interval, other: Interval) -> Interval:
    """Return the interval of the difference between two independent estimates.

    Source: Zou and Donner (2008), Construction of confidence limits about effect measures: a
    general approach.
    """
    difference = one.estimate - other.estimate
    below = math.hypot(one.estimate - one.low, other.high - other.estimate)
    above = math.hypot(one.high - one.estimate, other.estimate - other.low)
    return Interval(difference, difference - below, difference + above)


def ratio_interval(costs: np.ndarray, successes: np.ndarray) -> Interval | None:
    """Return the interval of a sum of costs divided by the number of successes.

    The ratio is linearised: its error is the error of the mean of
    ``(cost - ratio * success) / share``. This is a poor approximation with few successes, so that
    the interval is unknown with fewer than ``MIN_VALUES`` of them.

    Args:
        costs: costs of the trials, ``[n]``.
        successes: 1 or ``True`` for each trial that succeeded, ``[n]``.

    Returns:
        Ratio with its interval, or ``None`` without a success.

    Source: Cochran (1977), Sampling techniques, 3rd ed., chapter 6.
    """
    count = np.count_nonzero(successes)
    if not count:
        return None
    ratio = float(costs.sum()) / count
    if count < MIN_VALUES:
        return Interval(ratio)
    return mean_interval(ratio + (costs - ratio * successes) / np.mean(successes))


def mean_interval(values: np.ndarray) -> Interval | None:
    """Return the studentised bootstrap interval of the mean of some values ``[n]``.

    For skewed values, such as numbers of steps, this interval contains the mean more often than the
    percentile bootstrap does; ``tests/benchmarks/bench_sweep.py`` measures how often. The random
    numbers are fixed, so that the same values always have the same interval.

    Equal values have an interval of width 0. The interval is unknown with fewer than ``MIN_VALUES``
    values, and if nearly all values are equal. Return ``None`` without any value.

    Source: Efron and Tibshirani (1993), An introduction to the bootstrap, section 12.5.
    """
    if not len(values):
        return None
    values = values.astype(float)
    mean = float(values.mean())
    if len(values) < MIN_VALUES:
        return Interval(mean)
    if np.ptp(values) == 0:
        return Interval(mean, mean, mean)
    # The mean is subtracted first, so that large values lose no digits.
    errors = _studentised(values - mean)
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(errors, [tail, 1 - tail], method="nearest")
    unit = values.std(ddof=1) / math.sqrt(len(values))
    ends = mean - max(high, 0.0) * unit, mean - min(low, 0.0) * unit
    return Interval(mean, *map(float, ends)) if np.isfinite(ends).all() else Interval(mean)


def _studentised(values: np.ndarray) -> np.ndarray:
    """Return the mean of each resample, divided by the standard error of the resample.

    The values ``[n]`` must have the mean 0. The result is infinite for a resample of equal values.
    """
    stream = np.random.default_rng(0)
    count, means = len(values), list[np.ndarray]()
    at_once = max(1, BATCH_VALUES // count)
    for start in range(0, RESAMPLES, at_once):
        resamples = values[stream.integers(0, count, (min(at_once, RESAMPLES - start), count))]
        errors = resamples.std(axis=1, ddof=1) / math.sqrt(count)
        errors[np.ptp(resamples, axis=1) == 0] = 0.0  # rounding may have made it positive
        with np.errstate(divide="ignore"):
            means.append(resamples.mean(axis=1) / errors)
    return np.concatenate(means)


def share(interval: Interval) -> str:
    """Format a share with its interval if that is known, as in ``87.4% (85.2 to 89.3)``."""
    if not interval.is_known:
        return f"{interval.estimate:.1%}"
    return f"{interval.estimate:.1%} ({interval.low * 100:.1f} to {interval.high * 100:.1f})"


def mean(interval: Interval, unit: str) -> str:
    """Format a mean with its interval to three digits, as in ``49.9 steps (47.6 to 52.3)``.

    An unknown interval and an empty unit are left out.
    """
    estimate, low, high = interval
    digits = max(0, 2 - int(math.log10(max(abs(estimate), 1))))
    ends = f"({low:,.{digits}f} to {high:,.{digits}f})" if interval.is_known else ""
    words = (f"{estimate:,.{digits}f}", unit, ends)
    return " ".join(filter(None, words))


def above_interval(interval: Interval) -> str:
    """Format a mean with its interval on a second line, to save width in a table."""
    return mean(interval, "").replace(" (", "\n(")


def percent(part: float) -> str:
    """Format a share in whole percent, with ``<1%`` and ``>99%`` for a rounded 0% or 100%."""
    if 0 < part < 0.005:
        return "<1%"
    return ">99%" if 0.995 <= part < 1 else f"{part:.0%}"
