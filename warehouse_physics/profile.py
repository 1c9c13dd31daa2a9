"""Velocity profiles: how fast to drive, for how long, and how far a robot gets.

A motor takes two commands: a velocity, and later 0. It then changes the speed of the body by at
most a constant amount in each substep. The task of this file is to find the velocity and the two
times, in whole substeps of ``dt`` seconds, so that the body comes to rest exactly at its target.
Chipmunk first moves the positions of bodies and then changes their velocities. All formulas follow
from this order.

*Equal rates.* A robot at rest is commanded the speed ``v`` for ``n`` substeps and then 0. In a
substep its speed rises by at most ``a * dt`` or falls by at most ``b * dt``. With ``a = b`` the
distance that is lost while it speeds up is gained while it slows down. It therefore comes to rest
exactly ``n * dt * v`` from its start, provided that ``v <= n * a * dt``. So ``n`` is chosen first,
as small as the top speed and the acceleration allow, and ``v`` follows from the distance.

*Harder braking.* Where the drag of the floor alone is larger than the attainable acceleration,
``b`` is larger than ``a``. The robot then loses more than it gains, by nearly ``k * v * v`` with
``k = (1 / a - 1 / b) / 2``. Again ``n`` is chosen first, for the highest speed possible. ``v`` is
then the root of a quadratic equation, and Newton's method makes it exact, because the distance is
linear in ``v`` between the speeds that are reached after whole substeps.

*Substep by substep.* Robots that drive through cells get a new command in each substep. In a
substep a body first moves with the speed that it has and then takes the commanded speed. Speeds
that are chosen now therefore take effect on positions from the end of the next substep on. The
distances that ``stopping_speeds`` takes are measured from there.

``plan_profile`` does for one robot what ``plan_profiles`` does for an array of robots. Both exist
because NumPy takes ten times as long for a single number, which would be noticeable with a lone
robot.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Substeps = NDArray[np.int64]

_SLACK = 1e-4
"""Part of a substep that is not rounded up to a whole one, because rounding and the solver leave
about this much of a quotient that should be whole. The top speed may be exceeded by as small a
share."""

_ROUNDS = 8
"""Iterations of Newton's method. After 6 the distance is exact except for rounding, even with a
thousand substeps and with any rates."""


class Profile(NamedTuple):
    """Commanded velocity ``(x, y)`` in m/s, and the numbers of substeps to drive and to brake."""

    velocity: tuple[float, float]
    go: int
    brake: int

    def scaled(self, factor: float) -> Profile:
        """Return this profile with the velocity multiplied by a factor."""
        return self._replace(velocity=(factor * self.velocity[0], factor * self.velocity[1]))


def plan_profile(
    start: tuple[float, float],
    target: tuple[float, float],
    top_speed: float,
    acceleration: float,
    time_step: float,
    drag: float = 0.0,
) -> Profile:
    """Return the fastest profile from rest at ``start`` to rest at ``target``, both in metres.

    The robot brakes at ``acceleration``, or at ``drag`` if the floor alone brakes harder, both in
    m/s².
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
    """Return the substeps that a robot needs to brake from ``speed`` to rest."""
    return max(1, math.ceil(speed / (deceleration * time_step) - _SLACK))


def plan_profiles(
    displacements: Floats,
    top_speed: float,
    accelerations: Floats,
    time_step: float,
    drag: float = 0.0,
) -> tuple[Floats, Substeps, Substeps]:
    """Return the fastest profiles from rest to rest over ``displacements``, ``[N, 2]`` in metres.

    Returns:
        The velocities ``[N, 2]`` in m/s, and the substeps ``[N]`` to go and to brake.
    """
    lengths = lengths_of(displacements)
    seconds = np.maximum(lengths / top_speed, np.sqrt(lengths / accelerations))
    go = _whole(seconds / time_step)
    seconds = go * time_step
    hard = (drag > accelerations) & (lengths > 0)
    if hard.any():
        limits = top_speed, accelerations[hard], drag, time_step
        speeds, go[hard] = _hard_stops(lengths[hard], *limits)
        seconds[hard] = lengths[hard] / speeds
    brake = brakings(lengths / seconds, np.maximum(accelerations, drag), time_step)
    return displacements / seconds[:, None], go, brake


def brakings(speeds: Floats, decelerations: Floats, time_step: float) -> Substeps:
    """Return the substeps that robots need to brake from ``speeds`` to rest, ``[N]``."""
    return _whole(speeds / (decelerations * time_step))


def lengths_of(vectors: Floats) -> Floats:
    """Return the lengths of the vectors ``[N, 2]``, as ``[N]``."""
    return np.hypot(vectors[:, 0], vectors[:, 1])


def stopping_distances(speeds: Floats, rates: Floats, time_step: float) -> Floats:
    """Return how far robots that are commanded ``speeds`` get if they brake after that, in metres.

    The speeds are in m/s, and they brake at ``rates`` in m/s².
    """
    return speeds * (speeds + rates * time_step) / (2 * rates)


def stopping_speeds(distances: Floats, rates: Floats, time_step: float) -> Floats:
    """Return the highest speeds in m/s from which robots stop within ``distances`` in metres.

    They brake at ``rates`` in m/s². The speed is 0 where the distance is 0 or less.
    """
    room, half = np.maximum(distances, 0.0), rates * time_step / 2
    # The second term keeps the last substep from overshooting a very short distance.
    return np.minimum(np.sqrt(half * half + 2 * rates * room) - half, room / time_step)


def _whole(substeps: Floats) -> Substeps:
    return np.maximum(np.ceil(substeps - _SLACK), 1).astype(np.int64)


def _hard_stops(lengths: Any, top: float, rates: Any, drag: float, dt: float) -> tuple[Any, Any]:
    """Return speeds and substeps to drive for robots whose ``drag`` is above their ``rates``."""
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
    """Return the distance that robots lose while they reach a speed, and the substeps for it.

    The loss is relative to robots that have the speed from the beginning.
    """
    substeps = np.ceil(speeds / (rate * dt) - _SLACK)
    return dt * substeps * (speeds - rate * dt * (substeps - 1) / 2), substeps
