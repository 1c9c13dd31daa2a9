"""One drive from rest to rest, as two commands: go, then brake.

Chipmunk moves positions before it changes velocities. A robot at rest whose commanded speed is
``v`` for ``n`` substeps of ``dt`` and then 0, and whose motor changes its speed by at most
``a * dt`` a substep either way, speeds up and slows down along the same steps; what it misses
while it speeds up it makes up while it slows down. It ends at rest exactly ``n * dt * v`` further,
whatever ``a`` is, if only ``v <= n * a * dt``. So ``n`` is chosen first and ``v`` follows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

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
