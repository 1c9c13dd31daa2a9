"""What motors make of commanded speeds, given the actual floor and noise."""

from __future__ import annotations

import math

import numpy as np

from warehouse_core import Cell
from warehouse_core.world.tables import Flags
from warehouse_physics.disturbances import Disturbances, FloorConditions
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.driving.limits import Limits
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec

MIN_SPEED = 0.01
"""Speed in m/s below which robots do not measure how exactly they drive."""

MAX_EXCESS = 2.0
"""Largest ratio of the actual speed to the commanded one, as in ``speed_factor``."""


class Motors:
    """The motors of the robots of an arena.

    The force of each motor is limited by its strength, and by the grip and the drag of the cell
    under the robot. When a robot enters a cell, the ratio of its actual to its commanded speed
    becomes a new random number.

    Attributes:
        drags: ``[R]`` N, drag of the cells under the robots.
        pushes: ``[R]`` N, largest forces of the motors in these cells.
        factors: ``[R]``, ratios of the actual speeds to the commanded ones.
        is_exact: true if robots drive exactly as commanded.
    """

    def __init__(
        self,
        arena: DrivenArena,
        spec: RobotSpec,
        limits: Limits,
        disturbances: Disturbances,
        seed: int,
    ) -> None:
        self._arena, self._spec, self._limits = arena, spec, limits
        self._noise, self._floor = disturbances.actuation_noise, FloorConditions(disturbances, seed)
        self.is_exact = not self._noise and not self._floor.varies
        robots = len(arena.bodies)
        self.drags, self.pushes = np.zeros((2, robots))
        self.factors, self._drag_factors = np.ones((2, robots))
        self._cells = np.full((robots, 2), -1)
        self._speeding, self._braking = np.zeros((2, robots))
        self._forces = np.full(robots, math.nan)
        self._commands, self._expected = np.zeros((2, robots))

    def load(self) -> None:
        """Set the masses of the bodies and the forces of the motors for the present loads."""
        for body, mass in zip(self._arena.bodies, self._limits.masses.tolist(), strict=True):
            if body.mass != mass:
                body.mass = mass
        for robot in range(len(self.drags)):
            self._limit(robot)

    def feel(self, positions: Floats) -> list[int]:
        """Return the robots that have entered another cell, at positions ``[R, 2]`` in metres."""
        if self.is_exact:
            return []
        cells = np.floor(positions[:, ::-1] / self._spec.cell_size).astype(np.intp)
        entered: list[int] = (cells != self._cells).any(axis=1).nonzero()[0].tolist()
        for robot in entered:
            self._cells[robot] = cells[robot]
            self._drag_factors[robot] = self._floor.drag_factor(self._cell(robot))
            if self._noise:
                self.factors[robot] = self._floor.speed_factor()
            self._limit(robot)
        return entered

    def turn(self, robot: int, speed: float) -> None:
        """Forget the command of a robot that turns into its next leg.

        ``speed`` is its speed in the new direction, in m/s.
        """
        self._commands[robot] = self._expected[robot] = speed

    def excess(self, speeds: Floats) -> Floats:
        """Return how many times faster than commanded the robots drive, ``[R]`` and at least 1."""
        slowest = np.maximum(np.maximum(self._commands, self._expected), MIN_SPEED)
        return np.minimum(np.maximum(speeds / slowest, 1.0), MAX_EXCESS)

    def fastest(self, speeds: Floats, ups: Floats) -> Floats:
        """Return the highest speeds that may be commanded next, ``[R]`` m/s.

        The robots drive at ``speeds`` in m/s now, and speed up at the rates ``ups`` in m/s².
        """
        gained = ups * self._spec.time_step
        if not self.is_exact:  # the commanded speed may be above the actual one
            commands = np.minimum(self._commands, MAX_EXCESS * (speeds + gained))
            speeds = np.maximum(speeds, commands)
        faster = speeds + gained
        if (
            not self.is_exact
        ):  # a robot that drives back faster than commanded must be able to brake
            faster = np.where(speeds < 0, np.maximum(faster, 0.0), faster)
        return np.minimum(faster, self._spec.top_speed)

    def command(self, velocities: Floats, speeds: Floats, before: Floats, turns: Flags) -> Floats:
        """Set the forces of the motors, and return the velocities to aim for, ``[R, 2]`` m/s.

        Args:
            velocities: ``[R, 2]`` m/s, commanded velocities.
            speeds: ``[R]`` m/s, commanded speeds along the legs of the robots.
            before: ``[R]`` m/s, present speeds along the legs.
            turns: ``[R]`` bool, true if a robot is off the line of its leg.
        """
        if self.is_exact:
            return velocities
        step = self._limits.hardest * self._spec.time_step
        self._commands, self._expected = speeds.copy(), before - step
        is_speeding = (self.factors * speeds > before) & (before >= 0) & ~turns
        forces = np.where(is_speeding, self._speeding, self._braking)
        for robot in (forces != self._forces).nonzero()[0].tolist():
            self._arena.drives[robot].max_force = float(forces[robot])
        self._forces = forces
        return velocities * self.factors[:, None]

    def _limit(self, robot: int) -> None:
        """Set the largest net forces with which a robot speeds up and brakes, in N."""
        limits, spec = self._limits, self._spec
        mass, drag = float(limits.masses[robot]), float(limits.drags[robot])
        self.drags[robot] = drag = drag * float(self._drag_factors[robot])
        motor = self._floor.force_limit(self._cell(robot), spec.motor_force, mass)
        most = mass * min(spec.acceleration, spec.top_speed / spec.time_step)
        self.pushes[robot] = motor
        self._arena.hold(robot, self._floor.grip_force(self._cell(robot), mass) - drag)
        self._speeding[robot] = max(min(most, motor - drag), 0.0)
        self._braking[robot] = min(mass * spec.acceleration, motor + drag)
        if self.is_exact:
            self._arena.drives[robot].max_force = max(
                float(self._braking[robot]), float(self._speeding[robot])
            )

    def _cell(self, robot: int) -> Cell:
        row, col = self._cells[robot].tolist()
        return row, col
