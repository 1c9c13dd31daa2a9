"""Robots that one joint each drives, read and commanded as arrays.

The joint of a robot exerts the sum of its motor and the drag of the floor. Nothing turns the body:
the motion of a disc without friction does not depend on its heading.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import pymunk

from warehouse_physics.arena import Arena, Position
from warehouse_physics.body_arrays import BodyArrays
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec


class DrivenArena(Arena):
    """An arena with ``N`` such robots; see ``add_robots``.

    Attributes:
        drives: joint that drives each robot; its ``max_force`` limits the force in N.
    """

    def __init__(self, spec: RobotSpec, iterations: int) -> None:
        super().__init__(spec, iterations)
        # The control bodies are in a space of their own that is never stepped: joints use their
        # velocities, and their positions do not matter.
        self._panel = pymunk.Space()
        self.drives: list[pymunk.PivotJoint] = []

    def add_robots(self, positions: Iterable[Position]) -> None:
        """Add all robots at once, at rest at their positions."""
        for position in positions:
            # A body with an infinite moment never turns.
            body = pymunk.Body(self._spec.mass, math.inf)
            body.position = position
            control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            drive = pymunk.PivotJoint(body, control, (0, 0), (0, 0))
            # Errors of position are not corrected: the joint is a motor, not a spring.
            drive.error_bias = 1.0
            self._panel.add(control)
            self.add_robot(body, drive)
            self.drives.append(drive)
        self._bodies, self._controls = BodyArrays(self.space), BodyArrays(self._panel)

    def command(self, velocities: Floats) -> None:
        """Set the velocities ``[N, 2]`` in m/s for the drives to reach."""
        self._controls.write_velocities(velocities)

    def look(self) -> tuple[Floats, Floats]:
        """Return positions ``[N, 2]`` in metres and velocities ``[N, 2]`` in m/s."""
        return self._bodies.read()
