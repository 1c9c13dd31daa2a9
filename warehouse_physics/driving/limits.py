"""How fast ``R`` robots can speed up, brake and turn corners, with and without items."""

from __future__ import annotations

import math

import numpy as np

from warehouse_core.motion.grid import GRAVITY
from warehouse_physics.disturbances import Disturbances
from warehouse_physics.profile import Floats, stopping_distances
from warehouse_physics.spec import RobotSpec

CORNER = 0.5
"""Distance before the middle of a corner at which robots begin to turn, as a share of a cell. From
there they brake in the old direction while they speed up in the new one. They cut the corner from
one edge of its cell to the next, and stay half a cell away from the wall around which they turn."""

CAREFUL_CORNER = 0.2
"""The same distance for robots that do not drive exactly as commanded."""

SIGMAS = 3.0
"""Number of standard deviations of the actual speed for which robots can still brake in time."""

MIN_RATE = 1e-3
"""Smallest rate in m/s² that is assumed. It keeps distances finite for robots that cannot move."""


class Limits:
    """The limits of each robot that are known in advance, as arrays ``[R]``.

    Attributes:
        loaded: bool, true if the robot carries an item.
        slips: bool, true if the floor is slippery here, or within the distance that the robot needs
            to stop.
        masses: kg.
        drags: N, nominal drag of the floor.
        ups: m/s², rate at which the robot speeds up.
        downs: m/s², rate at which it can always brake.
        hardest: m/s², highest rate at which it may brake.
        corner_rates: m/s², rate at which it changes its speed in each direction at a corner.
        normal_reach: metres within which all robots stop on floor that is not slippery.
        reach: metres within which all robots stop on slippery floor.
        corner: metres before a corner at which robots begin to turn.
        corner_speeds: m/s, highest speed at which a robot may begin to turn.
        spare: metres left to a corner if a robot brakes from that speed where it could begin to
            turn.
    """

    def __init__(self, spec: RobotSpec, robots: int, disturbances: Disturbances) -> None:
        self._spec = spec
        self._masses = np.array([spec.total_mass(loaded) for loaded in (False, True)])
        self._drags = np.array([spec.drag_force(loaded) for loaded in (False, True)])
        spread = disturbances.drag_spread
        motor = np.full((2, 2), disturbances.motor_strength * spec.motor_force)
        self._hardest = np.minimum(
            spec.acceleration, (motor[0] + self._drags * (1 + spread)) / self._masses
        )
        # The first row is for normal floor and the second for slippery floor. Columns are loads.
        motor[1] = np.minimum(motor[1], disturbances.grip * self._masses * GRAVITY)
        most = min(spec.acceleration, spec.top_speed / spec.time_step)
        self._reserve = (1 + SIGMAS * disturbances.actuation_noise) ** 2
        is_exact = not disturbances.actuation_noise
        self.corner = (CORNER if is_exact else CAREFUL_CORNER) * spec.cell_size
        self._ups = np.clip((motor - self._drags) / self._masses, MIN_RATE, most)
        slowest = (motor + self._drags * (1 - spread)) / self._masses
        self._downs = np.clip(slowest, MIN_RATE, spec.acceleration) / self._reserve
        self.normal_reach, self.reach = spec.top_speed**2 / (2 * self._downs.min(axis=1))
        self.slips, self.loaded = np.zeros((2, robots), np.bool_)
        self.load(self.loaded)

    def load(self, loaded: np.ndarray) -> None:
        """Set which robots carry items, ``[R]`` bool."""
        self.loaded = loaded
        index = loaded.astype(np.intp)
        self.masses, self.drags = self._masses[index], self._drags[index]
        self.hardest = self._hardest[index]
        self.slip(self.slips)

    def slip(self, slips: np.ndarray) -> None:
        """Set which robots have to expect slippery floor, ``[R]`` bool."""
        self.slips = slips
        index = slips.astype(np.intp), self.loaded.astype(np.intp)
        self.ups, self.downs = self._ups[index], self._downs[index]
        self.corner_rates: Floats = self.ups / math.sqrt(2) / self._reserve
        self.corner_speeds: Floats = np.sqrt(2 * self.corner_rates * self.corner)
        stops = stopping_distances(self.corner_speeds, self.downs, self._spec.time_step)
        self.spare: Floats = self.corner - stops
