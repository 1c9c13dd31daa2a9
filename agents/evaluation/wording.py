"""Numbers as they stand in a sentence."""

from __future__ import annotations

import math

from agents.evaluation.interval import Interval


def share(interval: Interval) -> str:
    """Return a share with its interval, ``87.4% (85.2 to 89.3)``."""
    return f"{interval.estimate:.1%} ({interval.low * 100:.1f} to {interval.high * 100:.1f})"


def mean(interval: Interval, unit: str, also: str = "") -> str:
    """Return a mean with its interval to three digits, ``49.9 steps (47.6 to 52.3)``.

    Args:
        interval: of the mean; what is not known of it is left out.
        unit: of the mean; left out where it is empty.
        also: stands in the brackets too.
    """
    estimate, low, high = interval
    digits = max(0, 2 - int(math.log10(max(abs(estimate), 1))))
    ends = f"{low:,.{digits}f} to {high:,.{digits}f}" if interval.is_known else ""
    brackets = "; ".join(filter(None, (ends, also)))
    words = (f"{estimate:,.{digits}f}", unit, f"({brackets})" if brackets else "")
    return " ".join(filter(None, words))


def percent(part: float) -> str:
    """Return a share as whole percents, ``<1%`` and ``>99%`` where they would say none or all."""
    if 0 < part < 0.005:
        return "<1%"
    return ">99%" if 0.995 <= part < 1 else f"{part:.0%}"


def points(change: float) -> str:
    """Return a change of a share in points, ``+4.2 points``."""
    return f"{change * 100:+.1f} points"


def chance(probability: float) -> str:
    """Return a probability as it stands after a p."""
    return "p < 0.001" if probability < 0.001 else f"p = {probability:.3f}"


def sentence(words: str) -> str:
    """Return words with a capital and a full stop."""
    return f"{words[0].upper()}{words[1:]}."
