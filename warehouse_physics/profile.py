"""Velocity profiles from rest to rest, as two commands: go, then brake.

Chipmunk moves positions before it changes velocities. Let a robot at rest be commanded the speed
``v`` for ``n`` substeps of ``dt`` and then 0, and let its motor change its speed by at most
``a * dt`` in a substep. It then speeds up and slows down by the same steps, and the distance lost
while it speeds up is gained while it slows down. It ends at rest exactly ``n * dt * v`` farther,
whatever ``a`` is, as long as ``v <= n * a * dt``. So ``n`` is chosen first, and ``v`` follows.

The second half of this module does the same for ``N`` robots at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Substeps = NDArray[np.int64]

_SLACK = 1e-9
"""Of a substep; a quotient that is whole but for rounding is not rounded up."""


class Profile(NamedTuple):
    """Commanded velocity in m/s, and the numbers of substeps to go and then to brake."""

    velocity: tuple[float, float]
    go: int
    brake: int

    def scaled(self, factor: float) -> Profile:
        """Return the profile with its speed multiplied by a factor."""
        return self._replace(velocity=(factor * self.velocity[0], factor * self.velocity[1]))


def plan_profile(
    start: tuple[float, float],
    target: tuple[float, float],
    top_speed: float,
    acceleration: float,
    time_step: float,
) -> Profile:
    """Return the fastest profile from rest at ``start`` to rest at ``target``, in metres."""
    dx, dy = target[0] - start[0], target[1] - start[1]
    length = math.hypot(dx, dy)
    seconds = max(length / top_speed, math.sqrt(length / acceleration))
    go = max(1, math.ceil(seconds / time_step - _SLACK))
    seconds = go * time_step
    return Profile(
        (dx / seconds, dy / seconds), go, braking(length / seconds, acceleration, time_step)
    )


def braking(speed: float, acceleration: float, time_step: float) -> int:
    """Return the substeps until a robot that brakes from ``speed`` stands still."""
    return max(1, math.ceil(speed / (acceleration * time_step) - _SLACK))


def plan_profiles(
    ways: Floats, top_speed: float, accelerations: Floats, time_step: float
) -> tuple[Floats, Substeps, Substeps]:
    """Return the fastest profiles from rest to rest over ``ways``, ``[N, 2]`` in metres.

    Returns:
        The velocities ``[N, 2]`` in m/s, and the substeps ``[N]`` to go and to brake.
    """
    lengths = lengths_of(ways)
    seconds = np.maximum(lengths / top_speed, np.sqrt(lengths / accelerations))
    go = _whole(seconds / time_step)
    seconds = go * time_step
    brake = brakings(lengths / seconds, accelerations, time_step)
    return ways / seconds[:, None], go, brake


def brakings(speeds: Floats, accelerations: Floats, time_step: float) -> Substeps:
    """Return the substeps ``[N]`` until robots that brake from ``speeds`` stand still."""
    return _whole(speeds / (accelerations * time_step))


def lengths_of(vectors: Floats) -> Floats:
    """Return the lengths ``[N]`` of vectors ``[N, 2]``."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def _whole(substeps: Floats) -> Substeps:
    return np.maximum(np.ceil(substeps - _SLACK), 1).astype(np.int64)
