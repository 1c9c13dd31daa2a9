"""Robots with two driven wheels that drive through: they stop at corners and turn there.

A body drives along its leg with the force of its motor. Tyres hold it on the line of the leg, on
slippery floor with at most the grip. A robot that a hit has moved off its line steers back while it
drives. Turns are calculated in this file and not in Chipmunk, because nothing that touches a disc
without friction can turn it. They have the same moment of inertia, motor force, grip and drag as in
``wheeled_robot.py``. Wheels that turn are as inexact as wheels that drive.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk

from warehouse_core.world.tables import Flags
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.driving.headings import Headings
from warehouse_physics.driving.limits import Limits
from warehouse_physics.driving.motors import Motors
from warehouse_physics.energy import paid, work_in_substep
from warehouse_physics.profile import Floats, stopping_speeds
from warehouse_physics.spec import RobotSpec
from warehouse_physics.wheeled_robot import mass_on_line

LINE = 1e6
"""Distance in cells from the corner of a floor to the ends of the lines that guide robots."""

EXACT = 1e-6
"""Radians from its next direction at which a robot has finished its turn."""

STEERING = 0.2
"""Highest speed to the side of a robot that is off its line, as a share of its speed along it."""


class WheeledArena(DrivenArena):
    """An arena with robots whose drives push along their headings only."""

    def _joints(self, body: pymunk.Body, control: pymunk.Body) -> list[pymunk.Constraint]:
        """Return the drive, which acts along the heading, and the tyres, which act across it."""
        reach = LINE * self._spec.cell_size
        drive = pymunk.GrooveJoint(control, body, (0.0, -reach), (0.0, reach), (0, 0))
        tyres = pymunk.GrooveJoint(control, body, (-reach, 0.0), (reach, 0.0), (0, 0))
        return [drive, tyres]

    def face(self, robot: int, heading: float) -> None:
        """Set the heading in radians along which a robot and its control body drive."""
        self.drives[robot].a.angle = heading

    def hold(self, robot: int, force: float) -> None:
        """Let tyres hold a robot on its line with up to ``force`` N."""
        self.tyres[robot].max_force = max(force, 0.0)

    def _mass(self, robot: int, normal: pymunk.Vec2d) -> float:
        """Return the mass in kg with which a robot resists a push along ``normal``."""
        if self.tyres[robot].max_force < math.inf:
            return self.bodies[robot].mass
        heading = pymunk.Vec2d.from_polar(1.0, self.drives[robot].a.angle)
        return mass_on_line(self.bodies[robot].mass, heading.dot(normal))


class WheelHeadings(Headings):
    """The headings of ``R`` robots with two wheels; see ``Headings``.

    Attributes:
        work: ``[R]`` joules, work of the motors in turns so far.
    """

    def __init__(
        self, spec: RobotSpec, arena: WheeledArena, motors: Motors, limits: Limits
    ) -> None:
        super().__init__(spec, len(arena.bodies))
        self._spec, self._arena, self._motors, self._limits = spec, arena, motors, limits
        self._speeds = np.zeros(len(arena.bodies))  # m/s of wheels, negative in turns to the left

    def face(self, robot: int, direction: Floats, goes_back: bool = False) -> None:
        """Make a robot turn towards ``(x, y)``; a robot that goes back drives in reverse."""
        super().face(robot, direction)
        if goes_back:
            self._left[robot] = math.remainder(self._left[robot], math.pi)
        self._arena.face(robot, math.atan2(direction[1], direction[0]))

    def turn(self, stopped: Flags) -> Flags:
        """Turn robots for one substep, and return which of them must not drive in it, ``[R]``."""
        if not (self._left.any() or self._speeds.any()):
            return stopped
        spec, dt, before = self._spec, self._spec.time_step, self._speeds
        turned = before * dt / spec.wheel_arm
        self.angles += turned
        self._left -= turned
        self._left[np.abs(self._left) <= EXACT] = 0.0
        ups, downs = self._rates()
        sides = np.where(self._left == 0, np.sign(before), np.sign(self._left))
        speeds = sides * before
        wanted = stopping_speeds(np.abs(self._left) * spec.wheel_arm, downs, dt)
        wanted = np.where(stopped, 0.0, np.minimum(wanted, spec.top_speed) * self._motors.factors)
        slowest, fastest = speeds - downs * dt, speeds + np.where(speeds < 0, downs, ups) * dt
        self._speeds = sides * np.clip(wanted, slowest, fastest)
        self._count(before)
        is_turning: Flags = (self._left != 0) | (self._speeds != 0)
        return stopped | is_turning

    def steer(self, aside: Floats, speeds: Floats) -> Floats:
        """Return the speeds at which robots get back to their lines while they drive, ``[R]``."""
        most = STEERING * np.abs(speeds)
        return np.minimum(np.maximum(aside, -most), most)

    def _rates(self) -> tuple[Floats, Floats]:
        """Return the rates in m/s² at which wheels speed up and brake in turns, ``[R]`` each."""
        spec, pushes, drags = self._spec, self._motors.pushes, self._motors.drags
        masses = self._limits.masses / (2 * spec.track**2)
        most = min(spec.acceleration, spec.top_speed / spec.time_step)
        ups = np.clip((pushes - drags) / masses, 0.0, most)
        return ups, np.minimum((pushes + drags) / masses, spec.acceleration)

    def _count(self, before: Floats) -> None:
        """Add the work of the motors in a substep that began with the wheel speeds ``before``."""
        masses = self._limits.masses / (2 * self._spec.track**2)
        drags, dt = self._motors.drags, self._spec.time_step
        self.work += paid(self._spec, work_in_substep(masses, before, self._speeds, drags, dt))
