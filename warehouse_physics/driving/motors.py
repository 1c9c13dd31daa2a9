"""What the motors of ``R`` robots make of commands, on floors and with noise as they really are."""

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
"""Highest ratio of the speed to the commanded one: ``speed_factor`` draws none above it."""


class Motors:
    """The motors of the robots of an arena.

    Each limits its force by motor, floor and drag of the cell under the robot. For each cell that a
    robot enters, the share of the commanded speed that it really drives is drawn anew.

    Attributes:
        drags: ``[R]`` N, drag of the cells under the robots.
        pushes: ``[R]`` N, largest forces of the motors in these cells.
        factors: ``[R]`` actual speeds as shares of the commanded ones.
        is_exact: true if robots drive as they are commanded.
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
        """Give bodies the masses of their loads, and motors the forces that these need."""
        for body, mass in zip(self._arena.bodies, self._limits.masses.tolist(), strict=True):
            if body.mass != mass:
                body.mass = mass
        for robot in range(len(self.drags)):
            self._limit(robot)

    def feel(self, positions: Floats) -> list[int]:
        """Return which robots have entered other cells, at positions ``[R, 2]`` in metres."""
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
        """Forget what a robot was commanded, which drives at ``speed`` m/s in its new direction."""
        self._commands[robot] = self._expected[robot] = speed

    def excess(self, speeds: Floats) -> Floats:
        """Return how many times faster than commanded robots drive, ``[R]`` and at least 1."""
        slowest = np.maximum(np.maximum(self._commands, self._expected), MIN_SPEED)
        return np.minimum(np.maximum(speeds / slowest, 1.0), MAX_EXCESS)

    def fastest(self, speeds: Floats, ups: Floats) -> Floats:
        """Return the highest speeds that robots may be commanded next, ``[R]`` m/s.

        They drive at ``speeds`` now, and speed up at the rates ``ups`` in m/s².
        """
        gained = ups * self._spec.time_step
        if not self.is_exact:  # what is commanded may be more than what is driven
            commands = np.minimum(self._commands, MAX_EXCESS * (speeds + gained))
            speeds = np.maximum(speeds, commands)
        faster = speeds + gained
        if not self.is_exact:  # one that drives back faster than commanded has to be able to brake
            faster = np.where(speeds < 0, np.maximum(faster, 0.0), faster)
        return np.minimum(faster, self._spec.top_speed)

    def command(self, velocities: Floats, speeds: Floats, before: Floats, turns: Flags) -> Floats:
        """Set the forces of the motors, and return the velocities that they hold, ``[R, 2]`` m/s.

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
        """Set the largest net forces with which a robot speeds up and brakes."""
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
