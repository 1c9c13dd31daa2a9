"""Robots with a single drive joint each, which are read and commanded as arrays.

The joint of a robot exerts the sum of its motor and the drag of the floor. Bodies do not turn: the
motion of a disc without friction does not depend on its heading.

This is the only module that uses ``pymunk.batch``, which is experimental.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from warehouse_physics.arena import Arena, Position
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec


class DrivenArena(Arena):
    """An arena with ``N`` robots that are commanded as arrays.

    The ``max_force`` of each of the ``drives`` limits its force, in N.
    """

    def __init__(self, spec: RobotSpec, iterations: int) -> None:
        super().__init__(spec, iterations)
        # The control bodies are in a space of their own that is never stepped: joints use their
        # velocities, and their positions do not matter.
        self._panel = pymunk.Space()
        self.drives: list[pymunk.Constraint] = []
        self.tyres: list[pymunk.Constraint] = []

    def add_robots(self, positions: Iterable[Position]) -> None:
        """Add all robots at once, at rest at their positions."""
        for position in positions:
            # A body with an infinite moment never turns.
            body = pymunk.Body(self._spec.mass, math.inf)
            body.position = position
            control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            drive, *others = joints = self._joints(body, control)
            for joint in joints:
                # The joint is a motor and not a spring, so it does not correct errors of position.
                joint.error_bias = 1.0
            self._panel.add(control)
            self.add_robot(body, *joints)
            self.drives.append(drive)
            self.tyres.extend(others)
        self._bodies, self._controls = BodyArrays(self.space), BodyArrays(self._panel)

    def _joints(self, body: pymunk.Body, control: pymunk.Body) -> list[pymunk.Constraint]:
        """Return the joints of a robot, here one joint that drives it in any direction."""
        return [pymunk.PivotJoint(body, control, (0, 0), (0, 0))]

    def hold(self, robot: int, force: float) -> None:
        """Let tyres hold a robot on its line with up to ``force`` N; robots here have no tyres."""

    def command(self, velocities: Floats) -> None:
        """Set the velocities that the drives try to reach, ``[N, 2]`` in m/s."""
        self._controls.write_velocities(velocities)

    def look(self) -> tuple[Floats, Floats]:
        """Return the positions ``[N, 2]`` in metres and the velocities ``[N, 2]`` in m/s."""
        return self._bodies.read()


class BodyArrays:
    """Positions and velocities of the ``N`` moving bodies of a space, in the order of creation.

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
        """Return the positions ``[N, 2]`` in metres and the velocities ``[N, 2]`` in m/s."""
        self._seen.clear()
        get_space_bodies(self._space, BodyFields.POSITION | BodyFields.VELOCITY, self._seen)
        # A copy is needed because the next read fills the same memory.
        rows = np.frombuffer(self._seen.float_buf()).reshape(-1, 4)[: self._count].copy()
        return rows[:, :2], rows[:, 2:]

    def write_velocities(self, velocities: Floats) -> None:
        """Set the velocities ``[N, 2]`` in m/s."""
        self._velocities[: self._count] = velocities
        set_space_bodies(self._space, BodyFields.VELOCITY, self._given)
