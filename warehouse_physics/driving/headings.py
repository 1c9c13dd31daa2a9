"""The headings of robots that drive through, and which of them have to turn on the spot."""

from __future__ import annotations

import math

import numpy as np

from warehouse_core.world.tables import Flags
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec


class Headings:
    """The headings of ``R`` robots.

    A robot with ``turn_seconds`` turns on the spot before it drives, at a constant rate and in the
    shorter direction. Any other robot can drive in any direction, so its heading is the direction
    of its motion.

    Attributes:
        on_the_spot: true if robots stop to turn.
        angles: ``[R]`` radians; all robots face east at first.
        work: ``[R]`` joules, work of the motors in turns so far.
    """

    def __init__(self, spec: RobotSpec, robots: int) -> None:
        self.on_the_spot = spec.turns_on_the_spot
        self._most = math.inf
        if spec.turn_seconds:
            self._most = math.pi / 2 / spec.turn_seconds * spec.time_step
        self.angles, self._left, self.work = np.zeros((3, robots))

    def face(self, robot: int, direction: Floats, goes_back: bool = False) -> None:
        """Make a robot turn towards the direction ``(x, y)``, ``[2]``.

        ``goes_back`` makes a difference for robots with wheels only.
        """
        wanted = math.atan2(direction[1], direction[0])
        self._left[robot] = math.remainder(wanted - self.angles[robot], math.tau)

    def follow(self, velocities: Floats, moving: Flags) -> None:
        """Make the robots in ``moving``, ``[R]``, face the direction of their velocities."""
        if not self.on_the_spot:
            directions = np.arctan2(velocities[moving, 1], velocities[moving, 0])
            turns = directions - self.angles[moving]
            self.angles[moving] += np.remainder(turns + math.pi, math.tau) - math.pi

    def turn(self, stopped: Flags) -> Flags:
        """Turn robots for one substep, and return which of them must not drive in it, ``[R]``.

        These are the robots marked in ``stopped``, which do not turn either, and those that turn on
        the spot.
        """
        turned = np.minimum(np.maximum(self._left, -self._most), self._most)
        turned[stopped] = 0.0
        self.angles += turned
        self._left -= turned
        is_turning: Flags = turned != 0
        return stopped | (self.on_the_spot & is_turning)

    def steer(self, aside: Floats, speeds: Floats) -> Floats:
        """Return the speeds at which robots can get back to their lines, ``[R]`` m/s.

        Robots here move in any direction, so these are the wanted speeds ``aside``. Robots with
        wheels are limited by their ``speeds`` along the lines.
        """
        return aside
