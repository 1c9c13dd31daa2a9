"""Where robots believe they are: measured motion whose errors accumulate."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence

from warehouse_core.motion.base import Pose
from warehouse_physics.arena import Position
from warehouse_physics.profile import Floats

MOST = 3.0
"""Largest random error, in standard deviations."""


class Odometry:
    """The poses that ``R`` robots believe they have, which are right at first.

    In each call a robot measures how far its body has moved and turned. The measured distance is
    wrong by a random share with the standard deviation ``error``. The measured heading is wrong by
    ``error`` radians, also as a standard deviation, for each metre driven and each radian turned.
    Nothing corrects the heading, so the error of the position grows with the distance.

    Attributes:
        poses: pose ``(x, y, heading)`` of each robot, in metres and radians.

    Source: Thrun, Burgard and Fox (2005), Probabilistic Robotics, section 5.4: the odometry motion
    model, with one parameter.
    """

    def __init__(self, positions: Iterable[Position], error: float, seed: int) -> None:
        self.poses: list[Pose] = [(x, y, 0.0) for x, y in positions]
        self._drifts = [0.0] * len(self.poses)
        self._error = error
        # Separate random numbers keep the motion the same with and without odometry.
        self._random = random.Random(f"{seed} odometry")

    def measure(self, paths: Sequence[Floats]) -> None:
        """Measure the motion of all robots from the first row of their paths to the last."""
        for robot, path in enumerate(paths):
            _, right, down, turn = (path[-1] - path[0]).tolist()
            x, y, _ = self.poses[robot]
            turned = math.hypot(right, down) + abs(turn)
            self._drifts[robot] = drift = self._drifts[robot] + self._random_error() * turned
            share, cos, sin = 1 + self._random_error(), math.cos(drift), math.sin(drift)
            self.poses[robot] = (
                x + share * (right * cos - down * sin),
                y + share * (right * sin + down * cos),
                math.remainder(float(path[-1][3]) + drift, math.tau),
            )

    def _random_error(self) -> float:
        return self._error * min(max(self._random.gauss(0.0, 1.0), -MOST), MOST)
