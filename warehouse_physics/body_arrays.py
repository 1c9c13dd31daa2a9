"""Positions and velocities of all bodies of a space as arrays.

This is the only module that uses ``pymunk.batch``, which is experimental.
"""

from __future__ import annotations

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from warehouse_physics.profile import Floats


class BodyArrays:
    """The ``N`` moving bodies of a space, in the order in which they were added.

    No body may be added or removed later.
    """

    def __init__(self, space: pymunk.Space) -> None:
        self._space = space
        self._count = len(space.bodies)
        self._seen, self._given = Buffer(), Buffer()
        # The static body of the space, if it has one, comes after all others.
        self._velocities = np.zeros((self._count + 1, 2))
        self._given.set_float_buf(self._velocities)

    def read(self) -> tuple[Floats, Floats]:
        """Return positions ``[N, 2]`` in metres and velocities ``[N, 2]`` in m/s."""
        self._seen.clear()
        get_space_bodies(self._space, BodyFields.POSITION | BodyFields.VELOCITY, self._seen)
        # Copied because the next read fills the same memory.
        rows = np.frombuffer(self._seen.float_buf()).reshape(-1, 4)[: self._count].copy()
        return rows[:, :2], rows[:, 2:]

    def write_velocities(self, velocities: Floats) -> None:
        """Set the velocities ``[N, 2]`` in m/s."""
        self._velocities[: self._count] = velocities
        set_space_bodies(self._space, BodyFields.VELOCITY, self._given)
