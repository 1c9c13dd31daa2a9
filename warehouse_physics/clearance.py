"""How close straight ways come to a point, in metres."""

from __future__ import annotations

import math

Vector = tuple[float, float]


def apart(position: Vector, other: Vector) -> Vector:
    """Return the way to a position from another."""
    return position[0] - other[0], position[1] - other[1]


def comes_closer(before: Vector, after: Vector, reach: float) -> bool:
    """Return whether a straight way comes closer to the origin than ``reach``.

    One that starts closer may lead away from there.
    """
    way = apart(after, before)
    towards = -(before[0] * way[0] + before[1] * way[1])
    if towards <= 0:
        return False
    done = min(1.0, towards / (way[0] ** 2 + way[1] ** 2))
    return math.hypot(before[0] + done * way[0], before[1] + done * way[1]) < reach
