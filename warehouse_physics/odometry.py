"""Where robots believe they are: ways that they measure, whose errors add up."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence

from warehouse_core.motion.base import Pose
from warehouse_physics.arena import Position
from warehouse_physics.profile import Floats

MOST = 3.0
"""Standard deviations beyond which no error is drawn."""


class Odometry:
    """The poses that ``R`` robots believe in, which at first are right and head east.

    In each call a robot measures how far its body has come and turned. The way that it measures is
    wrong by a share with the standard deviation ``error``, and its heading by ``error`` radians for
    each metre and each radian that it turned. Nothing corrects a heading, so that the error of the
    position grows with the way.

    Attributes:
        poses: pose of each robot.

    Source: Thrun, Burgard and Fox (2005), Probabilistic Robotics, section 5.4, the odometry motion
    model with one parameter.
    """

    def __init__(self, positions: Iterable[Position], error: float, seed: int) -> None:
        self.poses: list[Pose] = [(x, y, 0.0) for x, y in positions]
        self._drifts = [0.0] * len(self.poses)
        self._error = error
        # The motion has a stream of its own, which is the same with and without odometry.
        self._draws = random.Random(f"{seed} odometry")

    def measure(self, paths: Sequence[Floats]) -> None:
        """Measure the ways of all robots from the first rows of their paths to the last."""
        for robot, path in enumerate(paths):
            _, right, down, turn = (path[-1] - path[0]).tolist()
            x, y, _ = self.poses[robot]
            turned = math.hypot(right, down) + abs(turn)
            self._drifts[robot] = drift = self._drifts[robot] + self._draw() * turned
            share, cos, sin = 1 + self._draw(), math.cos(drift), math.sin(drift)
            self.poses[robot] = (
                x + share * (right * cos - down * sin),
                y + share * (right * sin + down * cos),
                math.remainder(float(path[-1][3]) + drift, math.tau),
            )

    def _draw(self) -> float:
        return self._error * min(max(self._draws.gauss(0.0, 1.0), -MOST), MOST)
