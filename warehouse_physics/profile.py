"""Velocity profiles: how fast to drive, for how many substeps, and how far that leads.

Chipmunk moves positions before it changes velocities, and all formulas here follow from that.

*From rest to rest, as two commands: go, then brake.* Let a robot at rest be commanded the speed
``v`` for ``n`` substeps of ``dt`` and then 0, and let its speed change by at most ``a * dt`` in a
substep on the way up and ``b * dt`` on the way down. With ``a = b`` the distance lost while it
speeds up is gained while it slows down: it ends at rest exactly ``n * dt * v`` farther, as long as
``v <= n * a * dt``. So ``n`` is chosen first, and ``v`` follows.

Where the drag of the floor alone exceeds the attainable acceleration, ``b`` is larger and less is
gained than lost, by nearly ``k * v * v`` with ``k = (1 / a - 1 / b) / 2``. Again ``n`` is chosen
first, for the highest speed possible; ``v`` is the root of a quadratic equation, and then exact by
Newton's method, because the distance is linear between speeds of whole substeps.

*Substep by substep.* A body moves on with the speed that it has, and then takes the speed that it
is commanded. So the speeds that are chosen now decide where the bodies are from the end of the next
substep on, to which all distances of ``stopping_speeds`` are measured.

``plan_profile`` plans for one robot what ``plan_profiles`` does for an array of them: NumPy takes
ten times as long for a single number, which a lone robot would notice.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Substeps = NDArray[np.int64]

_SLACK = 1e-4
"""Part of a substep that is not rounded up to a whole one, because the solver leaves as much of a
quotient that should be whole. The top speed may be exceeded by as little."""

_ROUNDS = 8
"""Rounds of Newton's method. After 6 the distance is exact but for rounding, at a thousand substeps
and any rates too."""


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
    drag: float = 0.0,
) -> Profile:
    """Return the fastest profile from rest at ``start`` to rest at ``target``, in metres.

    The robot brakes at ``acceleration``, or at ``drag`` if the floor alone brakes harder.
    """
    dx, dy = target[0] - start[0], target[1] - start[1]
    length = math.hypot(dx, dy)
    if drag > acceleration and length > 0:
        speed, substeps = _hard_stops(length, top_speed, acceleration, drag, time_step)
        go, seconds = int(substeps), length / float(speed)
    else:
        seconds = max(length / top_speed, math.sqrt(length / acceleration))
        go = max(1, math.ceil(seconds / time_step - _SLACK))
        seconds = go * time_step
    brake = braking(length / seconds, max(acceleration, drag), time_step)
    return Profile((dx / seconds, dy / seconds), go, brake)


def braking(speed: float, deceleration: float, time_step: float) -> int:
    """Return the substeps until a robot that brakes from ``speed`` stands still."""
    return max(1, math.ceil(speed / (deceleration * time_step) - _SLACK))


def plan_profiles(
    ways: Floats, top_speed: float, accelerations: Floats, time_step: float, drag: float = 0.0
) -> tuple[Floats, Substeps, Substeps]:
    """Return the fastest profiles from rest to rest over ``ways``, ``[N, 2]`` in metres.

    Returns:
        The velocities ``[N, 2]`` in m/s, and the substeps ``[N]`` to go and to brake.
    """
    lengths = lengths_of(ways)
    seconds = np.maximum(lengths / top_speed, np.sqrt(lengths / accelerations))
    go = _whole(seconds / time_step)
    seconds = go * time_step
    hard = (drag > accelerations) & (lengths > 0)
    if hard.any():
        limits = top_speed, accelerations[hard], drag, time_step
        speeds, go[hard] = _hard_stops(lengths[hard], *limits)
        seconds[hard] = lengths[hard] / speeds
    brake = brakings(lengths / seconds, np.maximum(accelerations, drag), time_step)
    return ways / seconds[:, None], go, brake


def brakings(speeds: Floats, decelerations: Floats, time_step: float) -> Substeps:
    """Return the substeps ``[N]`` until robots that brake from ``speeds`` stand still."""
    return _whole(speeds / (decelerations * time_step))


def lengths_of(vectors: Floats) -> Floats:
    """Return the lengths ``[N]`` of vectors ``[N, 2]``."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def stopping_distances(speeds: Floats, rates: Floats, time_step: float) -> Floats:
    """Return how far robots move after they are commanded ``speeds``, if they then brake."""
    return speeds * (speeds + rates * time_step) / (2 * rates)


def stopping_speeds(distances: Floats, rates: Floats, time_step: float) -> Floats:
    """Return the highest speeds from which robots stop within ``distances``; 0 where they cannot.

    They brake at ``rates`` in m/s².
    """
    ways, half = np.maximum(distances, 0.0), rates * time_step / 2
    # The last substep may be too short for a whole step of speed, so a way is also not overshot.
    return np.minimum(np.sqrt(half * half + 2 * rates * ways) - half, ways / time_step)


def _whole(substeps: Floats) -> Substeps:
    return np.maximum(np.ceil(substeps - _SLACK), 1).astype(np.int64)


def _hard_stops(lengths: Any, top: float, rates: Any, drag: float, dt: float) -> tuple[Any, Any]:
    """Return the speeds and substeps to go of robots that brake at ``drag``, above their rates."""
    k = (1 / rates - 1 / drag) / 2
    peaks = np.minimum(top, np.sqrt(2 * rates * lengths / (1 + rates / drag)))
    go = _whole((lengths / peaks + k * peaks) / dt)
    seconds = go * dt
    speeds = 2 * lengths / (seconds + np.sqrt(np.maximum(seconds**2 - 4 * k * lengths, 0)))
    for _ in range(_ROUNDS):
        (lost, up), (gained, down) = _lag(speeds, rates, dt), _lag(speeds, drag, dt)
        missing = lengths - (seconds * speeds - lost + gained)
        speeds = np.minimum(speeds + missing / (dt * (go - up + down)), seconds * rates)
    return speeds, go


def _lag(speeds: Any, rate: Any, dt: float) -> tuple[Any, Any]:
    """Return the distance lost while robots reach a speed, and in how many substeps."""
    substeps = np.ceil(speeds / (rate * dt) - _SLACK)
    return dt * substeps * (speeds - rate * dt * (substeps - 1) / 2), substeps
