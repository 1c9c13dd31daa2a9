"""Where robots face while they drive, and who of them has to turn on the spot first."""

from __future__ import annotations

import math

import numpy as np

from warehouse_core.world.tables import Flags
from warehouse_physics.profile import Floats
from warehouse_physics.robot import TURN_RATE, TURN_SECONDS
from warehouse_physics.spec import RobotSpec


class Headings:
    """The headings of ``R`` robots, which turn at a constant rate, the shorter way round.

    A robot with ``turn_seconds`` turns ``on_the_spot`` before it drives. Any other turns while it
    drives, as in ``robot.py``, which makes no difference to where it goes. The ``angles`` are
    ``[R]`` radians; at first all face east.
    """

    def __init__(self, spec: RobotSpec, robots: int) -> None:
        self.on_the_spot = spec.turn_seconds > 0
        rate = TURN_RATE * TURN_SECONDS / spec.move_seconds(loaded=False)
        if self.on_the_spot:
            rate = math.pi / 2 / spec.turn_seconds
        self._most = rate * spec.time_step
        self.angles, self._left = np.zeros((2, robots))

    def face(self, robot: int, direction: Floats) -> None:
        """Let a robot turn towards ``(x, y)``, ``[2]``."""
        wanted = math.atan2(direction[1], direction[0])
        self._left[robot] = math.remainder(wanted - self.angles[robot], math.tau)

    def turn(self, stands: Flags) -> Flags:
        """Turn robots for a substep; return who has stopped, or turns on the spot, ``[R]``.

        Robots that ``stands`` marks have stopped, and do not turn.
        """
        turned = np.minimum(np.maximum(self._left, -self._most), self._most)
        turned[stands] = 0.0
        self.angles += turned
        self._left -= turned
        is_turning: Flags = turned != 0
        return stands | (self.on_the_spot & is_turning)
