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
    drives, as in ``robot.py``, which makes no difference to where it goes.

    Attributes:
        on_the_spot: true if robots stop to turn.
        angles: ``[R]`` radians; at first all face east.
        work: ``[R]`` joules, work of the motors in turns so far.
    """

    def __init__(self, spec: RobotSpec, robots: int) -> None:
        self.on_the_spot = spec.turn_seconds > 0
        rate = TURN_RATE * TURN_SECONDS / spec.move_seconds(loaded=False)
        if self.on_the_spot:
            rate = math.pi / 2 / spec.turn_seconds
        self._most = rate * spec.time_step
        self.angles, self._left, self.work = np.zeros((3, robots))

    def face(self, robot: int, direction: Floats, is_moving: bool = False) -> None:
        """Let a robot, which may be moving, turn towards ``(x, y)``, ``[2]``."""
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

    def steer(self, aside: Floats, speeds: Floats) -> Floats:
        """Return the speeds at which robots get back to their lines, of those wanted, ``[R]``.

        Their ``speeds`` along the lines do not matter here.
        """
        return aside
