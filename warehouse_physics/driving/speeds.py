"""The highest speeds with which robots can still stop in time, in substeps.

In each substep a body moves on with the speed that it has, and then takes the speed that it is
commanded. So the speeds that are chosen now decide where the bodies are from the end of the next
substep on, to which all distances here are measured.
"""

from __future__ import annotations

import numpy as np

from warehouse_physics.profile import Floats


def stopping_distances(speeds: Floats, rates: Floats, time_step: float) -> Floats:
    """Return how far robots move from the speeds on that they are commanded, if they then brake."""
    found: Floats = speeds * (speeds + rates * time_step) / (2 * rates)
    return found


def stopping_speeds(distances: Floats, rates: Floats, time_step: float) -> Floats:
    """Return the highest speeds from which robots stop within ``distances``; 0 where they cannot.

    Args:
        distances: in metres.
        rates: of braking, in m/s².
        time_step: of a substep, in seconds.
    """
    ways, half = np.maximum(distances, 0.0), rates * time_step / 2
    found: Floats = np.minimum(np.sqrt(half * half + 2 * rates * ways) - half, ways / time_step)
    return found
