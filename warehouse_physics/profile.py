"""One drive from rest to rest, as two commands: go, then brake.

Chipmunk moves positions before it changes velocities. A robot at rest whose commanded speed is
``v`` for ``n`` substeps of ``dt`` and then 0, and whose motor changes its speed by at most
``a * dt`` a substep either way, speeds up and slows down along the same steps; what it misses
while it speeds up it makes up while it slows down. It ends at rest exactly ``n * dt * v`` further,
whatever ``a`` is, if only ``v <= n * a * dt``. So ``n`` is chosen first and ``v`` follows.

The second half of the file is the first half for ``N`` robots at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Substeps = NDArray[np.int64]

_SLACK = 1e-9
"""Of a substep; keeps a quotient that is whole but for rounding from being rounded up."""


class Leg(NamedTuple):
    """Commanded velocity in m/s, and for how many substeps to go and then to brake."""

    velocity: tuple[float, float]
    go: int
    brake: int

    def scaled(self, factor: float) -> Leg:
        """Return the same leg with its speed off by a factor."""
        return self._replace(velocity=(factor * self.velocity[0], factor * self.velocity[1]))


def plan_leg(
    start: tuple[float, float],
    target: tuple[float, float],
    top_speed: float,
    acceleration: float,
    time_step: float,
) -> Leg:
    """Return the fastest leg from rest at ``start`` to rest at ``target``, positions in metres."""
    dx, dy = target[0] - start[0], target[1] - start[1]
    length = math.hypot(dx, dy)
    seconds = max(length / top_speed, math.sqrt(length / acceleration))
    go = max(1, math.ceil(seconds / time_step - _SLACK))
    seconds = go * time_step
    return Leg((dx / seconds, dy / seconds), go, braking(length / seconds, acceleration, time_step))


def braking(speed: float, acceleration: float, time_step: float) -> int:
    """Return the substeps until a robot that brakes from ``speed`` stands still."""
    return max(1, math.ceil(speed / (acceleration * time_step) - _SLACK))


class Legs(NamedTuple):
    """Commanded velocities ``[N, 2]`` in m/s, and for how many substeps ``[N]`` to go and brake."""

    velocities: Floats
    go: Substeps
    brake: Substeps


def plan_legs(ways: Floats, top_speed: float, accelerations: Floats, time_step: float) -> Legs:
    """Return the fastest legs from rest to rest over ``ways``, ``[N, 2]`` in metres."""
    lengths = lengths_of(ways)
    seconds = np.maximum(lengths / top_speed, np.sqrt(lengths / accelerations))
    go = _whole(seconds / time_step)
    seconds = go * time_step
    brake = brakings(lengths / seconds, accelerations, time_step)
    return Legs(ways / seconds[:, None], go, brake)


def brakings(speeds: Floats, accelerations: Floats, time_step: float) -> Substeps:
    """Return the substeps ``[N]`` until robots that brake from ``speeds`` stand still."""
    return _whole(speeds / (accelerations * time_step))


def lengths_of(vectors: Floats) -> Floats:
    """Return the lengths ``[N]`` of vectors ``[N, 2]``."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def _whole(substeps: Floats) -> Substeps:
    return np.maximum(np.ceil(substeps - _SLACK), 1).astype(np.int64)
