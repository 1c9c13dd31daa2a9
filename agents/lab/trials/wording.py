"""Functions that format numbers and sentences."""

from __future__ import annotations

import math

from agents.lab.trials.interval import Interval


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


def sentence(words: str) -> str:
    """Return words as a sentence, with a capital letter and a full stop."""
    return f"{words[0].upper()}{words[1:]}."
