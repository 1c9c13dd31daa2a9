"""Integrals of sampled values, which older versions of NumPy have under another name."""

from collections.abc import Sequence

import numpy as np


def integral(values: Sequence[float], times: Sequence[float]) -> float:
    """Return the integral of values ``[K]`` over their times ``[K]``, linear in between."""
    heights = np.asarray(values)
    return float(((heights[1:] + heights[:-1]) / 2 * np.diff(times)).sum())
