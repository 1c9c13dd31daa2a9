"""Numbers and lists in sentences."""

from __future__ import annotations

import math

from agents.lab.trials.interval import Interval


def share(interval: Interval) -> str:
    """Return a share with its interval, ``87.4% (85.2 to 89.3)``, unless that is unknown."""
    if not interval.is_known:
        return f"{interval.estimate:.1%}"
    return f"{interval.estimate:.1%} ({interval.low * 100:.1f} to {interval.high * 100:.1f})"


def mean(interval: Interval, unit: str) -> str:
    """Return a mean with its interval to three digits, ``49.9 steps (47.6 to 52.3)``.

    Ends that are unknown are left out, and so is a unit of "".
    """
    estimate, low, high = interval
    digits = max(0, 2 - int(math.log10(max(abs(estimate), 1))))
    ends = f"({low:,.{digits}f} to {high:,.{digits}f})" if interval.is_known else ""
    words = (f"{estimate:,.{digits}f}", unit, ends)
    return " ".join(filter(None, words))


def above_interval(interval: Interval) -> str:
    """Return a mean above its interval, to save width in a table."""
    return mean(interval, "").replace(" (", "\n(")


def percent(part: float) -> str:
    """Return a share in whole percents; ``<1%`` and ``>99%`` instead of a rounded 0% or 100%."""
    if 0 < part < 0.005:
        return "<1%"
    return ">99%" if 0.995 <= part < 1 else f"{part:.0%}"


def sentence(words: str) -> str:
    """Return words with a capital letter and a full stop."""
    return f"{words[0].upper()}{words[1:]}."
