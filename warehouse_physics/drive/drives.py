"""The law of each kind of drive: the force with which motors answer a command in one substep.

The law is the same for a disc that is pushed in any direction and for a robot with two wheels:

1. A command is a velocity that the motors try to reach, or a force.
2. A motor changes the speed by at most ``acceleration * dt`` in a substep of ``dt`` seconds. The
   force that this takes is ``mass * change / dt`` plus the drag of the floor. The motor exerts it
   up to its largest force.
3. The drag opposes the motion. Like all friction it can stop a robot, but not push it back.
4. The work of a motor is its force times the mean of the speeds before and after the substep.

A disc has one motor, which acts in any direction. A robot with two wheels has a motor at each
wheel, with half of the force and of the drag. Its tyres hold it on its heading with as much force
as the grip allows.

Chipmunk moves bodies before it changes their velocities. The velocity of a robot with wheels is
therefore along the heading that it will have in the middle of the next move. Otherwise it would
drive along circles that are too large.

All functions take arrays with a column for each of ``N`` robots: a vector per robot is ``[2, N]``.
NumPy works on such arrays several times faster than on ``[N, 2]``, and this file is calculated in
each substep.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from warehouse_core.arguments import one_of
from warehouse_physics.energy import paid
from warehouse_physics.profile import Floats, lengths_of
from warehouse_physics.spec import RobotSpec

VELOCITY, WHEELS, FORCE = "velocity", "wheels", "force"
CONTROLS = (VELOCITY, WHEELS, FORCE)
"""Quantities that the two numbers of an action may command; see ``DriveEnv``."""

TINY = 1e-200
"""Smallest length by which vectors are divided, so that a vector of length 0 stays 0."""


@dataclass(slots=True)
class BodyState:
    """Where ``N`` bodies are and how they move, with a row for each of them.

    Attributes:
        positions: ``[N, 2]`` metres.
        angles: ``[N]`` radians, headings.
        velocities: ``[N, 2]`` m/s.
        turn_rates: ``[N]`` rad/s.
    """

    positions: Floats
    angles: Floats
    velocities: Floats
    turn_rates: Floats


class Loads:
    """What ``N`` robots have to move, and with which forces, as arrays ``[N]``.

    Call ``settle`` after you have changed an array.

    Attributes:
        masses: kg.
        drags: N, drag of the floor under the robot.
        motors: N, largest force of the motor here.
        grips: N, largest force of the tyres to the side; infinite if they hold.
        is_weak: true if a motor is weaker than the drag.
        slips: true if tyres may slip.
    """

    def __init__(self, rows: int) -> None:
        self.masses, self.drags, self.motors, self.grips = np.ones((4, rows))
        self.settle()

    def settle(self) -> None:
        """Update what follows from the arrays."""
        self.is_weak = bool((self.motors < self.drags).any())
        self.slips = bool(np.isfinite(self.grips).any())


class Thrust(NamedTuple):
    """What the motors and the floor do to ``N`` bodies in a substep.

    Attributes:
        forces: ``[2, N]`` N, total force.
        torques: ``[N]`` N·m, total torque.
        motors: ``[2, N]`` N, force of the motor alone, as a vector.
        parts: ``[2, N]`` N, forces of the motors, for their work: along both axes, or of both
            wheels.
    """

    forces: Floats
    torques: Floats
    motors: Floats
    parts: Floats


class Drive(ABC):
    """The drive of ``N`` robots of one kind."""

    controls: ClassVar[tuple[str, ...]]
    """Commands that robots of this kind understand."""

    def __init__(self, spec: RobotSpec, control: str, rows: int) -> None:
        one_of("control", control, self.controls)
        self._spec, self._dt, self._still = spec, spec.time_step, np.zeros(rows)
        self._is_force = control == FORCE
        self._control = control

    @abstractmethod
    def command(self, actions: Floats) -> Floats:
        """Return the commands for ``[N, 2]`` actions: ``[2, N]`` m/s, or N to control forces.

        The actions are numbers from -1 to 1.
        """

    @abstractmethod
    def speeds(self, state: BodyState) -> Floats:
        """Return the speeds ``[2, N]`` m/s at which the motors act."""

    @abstractmethod
    def push(self, state: BodyState, speeds: Floats, commands: Floats, loads: Loads) -> Thrust:
        """Return the forces of the next substep, for ``speeds`` of this state."""

    def work(self, push: Thrust, before: Floats, after: Floats) -> Floats:
        """Return the work ``[N]`` J for which the battery pays in a substep; see ``energy.py``.

        ``before`` and ``after`` are ``speeds`` at the ends of the substep. The work of a motor that
        brakes is at most 0.
        """
        first, second = paid(self._spec, push.parts * (before + after) * (self._dt / 2))
        work: Floats = first + second
        return work


class OmnidirectionalDrive(Drive):
    """The drive of discs that a single motor pushes in any direction."""

    controls = (VELOCITY, FORCE)

    def command(self, actions: Floats) -> Floats:
        """Return velocities or forces, whose length is at most the largest one."""
        most = self._spec.motor_force if self._is_force else self._spec.top_speed
        return _at_most(actions.T, 1.0) * most

    def push(self, state: BodyState, speeds: Floats, commands: Floats, loads: Loads) -> Thrust:
        """Return the forces of the next substep; see ``Drive.push``."""
        dt, spec, velocities = self._dt, self._spec, speeds
        masses, drags = loads.masses / dt, loads.drags
        if self._is_force:
            motors = _at_most(commands, loads.motors)
            drag = self._drag(velocities, motors, masses, drags)
            # No motor drives a robot faster than its top speed.
            fastest = np.maximum(lengths_of(velocities.T), spec.top_speed)
            after = _at_most(velocities + (motors - drag) / masses, fastest)
            motors = masses * (after - velocities) + drag
        else:
            gains = _at_most(commands - velocities, spec.acceleration * dt)
            drag = drags * _directions(velocities + gains / 2)
            motors = _at_most(masses * gains + drag, loads.motors)
            if loads.is_weak:
                drag = self._drag(velocities, motors, masses, drags)
        return Thrust(motors - drag, self._still, motors, motors)

    @staticmethod
    def _drag(velocities: Floats, motors: Floats, masses: Floats, drags: Floats) -> Floats:
        """Return the mean force ``[2, N]`` N of the floor in a substep, against the motion."""
        ahead = _directions(velocities + motors / masses / 2)
        speeds, forces = (_dots(vectors, ahead) for vectors in (velocities, motors))
        drag: Floats = ahead * rolling(speeds, forces, masses, drags)
        return drag

    def speeds(self, state: BodyState) -> Floats:
        """Return the two components of the velocities, at which the motor acts."""
        return state.velocities.T

    def work(self, push: Thrust, before: Floats, after: Floats) -> Floats:
        """Return the work for which the battery pays; see ``Drive.work``.

        The motor acts in one direction, so the work along both axes is a single amount.
        """
        return paid(self._spec, _dots(push.parts, before + after) * (self._dt / 2))


class WheelDrive(Drive):
    """The drive of robots with a left and a right wheel, each with a motor."""

    controls = CONTROLS

    def __init__(self, spec: RobotSpec, control: str, rows: int) -> None:
        super().__init__(spec, control, rows)
        self._arm, self._turning = spec.wheel_arm, 1 / (2 * spec.track**2)

    def command(self, actions: Floats) -> Floats:
        """Return the speeds or forces of the left and the right wheel.

        Wheels that are commanded more than they can do are slowed down together, so that the robot
        still drives along the same curve.
        """
        left, right = actions.T
        if self._control != WHEELS:
            left, right = left + right, left - right
        wheels = np.stack([left, right])
        most = self._spec.motor_force / 2 if self._is_force else self._spec.top_speed
        commands: Floats = wheels / np.maximum(np.abs(wheels).max(axis=0), 1.0) * most
        return commands

    def push(self, state: BodyState, speeds: Floats, commands: Floats, loads: Loads) -> Thrust:
        """Return the forces of the next substep; see ``Drive.push``."""
        dt, spec, masses = self._dt, self._spec, loads.masses
        most, drags = loads.motors / 2, loads.drags / 2
        # A force on one wheel moves it as if it were alone and had this mass.
        alone = masses / (dt * (1 + 1 / self._turning))
        if self._is_force:
            motors = _within(commands, most)
            drag = rolling(speeds, motors, alone, drags)
            # No motor drives a wheel faster than its top speed.
            fastest = np.maximum(np.abs(speeds), spec.top_speed)
            gains = _within(speeds + self._gains(motors - drag, masses), fastest) - speeds
        else:
            gains = _within(commands - speeds, spec.acceleration * dt)
            drag = drags * np.sign(speeds + gains / 2)
        motors = _within(self._forces(gains, masses) + drag, most)
        if loads.is_weak and not self._is_force:
            drag = rolling(speeds, motors, alone, drags)
        left, right = motors - drag
        spin = (left - right) * dt / (masses * self._turning) / self._arm
        ahead = (speeds[0] + speeds[1]) / 2
        forces, heading = self._steered(state, ahead, (left + right) * dt / masses, spin, loads)
        torques = (left - right) * self._arm
        return Thrust(forces, torques, (motors[0] + motors[1]) * heading, motors)

    def _forces(self, gains: Floats, masses: Floats) -> Floats:
        """Return the forces of the wheels for gains in their speeds, both ``[2, N]``.

        Both wheels push the mass, and their difference turns the disc.
        """
        both, turn = gains[0] + gains[1], self._turning * (gains[0] - gains[1])
        return _wheels(both, turn) * (masses / (4 * self._dt))

    def _gains(self, forces: Floats, masses: Floats) -> Floats:
        """Return the gains in the speeds of the wheels for their forces, both ``[2, N]``."""
        both, turn = forces[0] + forces[1], (forces[0] - forces[1]) / self._turning
        return _wheels(both, turn) * (self._dt / masses)

    def speeds(self, state: BodyState) -> Floats:
        """Return the speeds of the left and the right wheel."""
        ahead = _dots(state.velocities.T, _vectors(self._course(state)))
        turn = state.turn_rates * self._arm
        return _wheels(ahead, turn)

    def _course(self, state: BodyState) -> Floats:
        """Return the headings ``[N]`` in the middle of the next move, along which robots drive."""
        return state.angles + state.turn_rates * (self._dt / 2)

    def _steered(
        self, state: BodyState, ahead: Floats, gain: Floats, spin: Floats, loads: Loads
    ) -> tuple[Floats, Floats]:
        """Return the total forces ``[2, N]`` of wheels and tyres, and the new headings ``[2, N]``.

        ``ahead`` is the speed along the heading in m/s, ``gain`` the gain in it, and ``spin`` the
        gain in turn rate in rad/s, all ``[N]``.
        """
        dt, velocities = self._dt, state.velocities.T
        heading = _vectors(self._course(state) + (state.turn_rates + spin / 2) * dt)
        if loads.slips:
            slips = np.isfinite(loads.grips)
            # Tyres that slip can change the speed to the side by at most ``held``.
            held, aside = loads.grips * dt / loads.masses, np.stack([-heading[1], heading[0]])
            slide = _dots(velocities, aside)
            across = np.where(slips, slide - _within(slide, held), 0.0)
            ahead = np.where(slips, _dots(velocities, heading), ahead)
            wanted = (ahead + gain) * heading + across * aside
        else:
            wanted = (ahead + gain) * heading
        return loads.masses / dt * (wanted - velocities), heading


def drive_of(spec: RobotSpec, control: str, rows: int) -> Drive:
    """Return the drive of a kind of robot.

    Raises:
        ValueError: robots of this kind do not understand the control.
    """
    one_of("control", control, CONTROLS)
    kind = WheelDrive if spec.is_differential else OmnidirectionalDrive
    if control not in kind.controls:
        allowed = ", ".join(map(repr, kind.controls))
        raise ValueError(f"control is {control!r}; a robot with drive {spec.drive!r} has {allowed}")
    return kind(spec, control, rows)


def rolling(speeds: Floats, motors: Floats, masses: Floats, drags: Floats) -> Floats:
    """Return the mean drag in N during a substep, with the sign of the motion that it opposes.

    The drag stops what rolls. A robot at rest sets off only if its motor is stronger.

    Args:
        speeds: m/s at the start of the substep.
        motors: N, forces of motors.
        masses: kg/s, masses divided by the duration of the substep.
        drags: N, drag of the floor on what moves.
    """
    side = np.where(speeds == 0, np.sign(motors), np.sign(speeds))
    gains = (motors - side * drags) / masses
    after = speeds + gains
    # From the moment at which it stands, a robot stays or goes back.
    starts = np.sign(motors) * np.maximum(np.abs(motors) - drags, 0.0) / masses
    left = np.clip(1 + speeds / np.where(gains == 0, 1.0, gains), 0.0, 1.0)
    after = np.where(after * side < 0, starts * left, after)
    drag: Floats = motors - masses * (after - speeds)
    return drag


def _within(numbers: Floats, most: Floats | float) -> Floats:
    """Return numbers of at least ``-most`` and at most ``most``; ``np.clip`` takes longer."""
    limited: Floats = np.minimum(np.maximum(numbers, -most), most)
    return limited


def _wheels(both: Floats, turn: Floats) -> Floats:
    """Return ``[2, N]`` numbers of the left and right wheels: the left one has ``turn`` more."""
    return np.array([both + turn, both - turn])


def _at_most(vectors: Floats, most: Floats | float) -> Floats:
    """Return vectors ``[2, N]``, shortened to a length of at most ``most``, a number or ``[N]``."""
    return vectors * np.minimum(most / _divisors(vectors), 1.0)


def _directions(vectors: Floats) -> Floats:
    """Return vectors ``[2, N]`` with the length 1, or 0 where a vector is 0."""
    return vectors / _divisors(vectors)


def _divisors(vectors: Floats) -> Floats:
    """Return the lengths ``[N]`` of vectors ``[2, N]``, or ``TINY`` where a length is 0."""
    lengths: Floats = np.maximum(lengths_of(vectors.T), TINY)
    return lengths


def _dots(some: Floats, others: Floats) -> Floats:
    """Return the dot products ``[N]`` of vectors ``[2, N]``."""
    across, down = some * others
    products: Floats = across + down
    return products


def _vectors(angles: Floats) -> Floats:
    """Return the vectors ``[2, N]`` of length 1 for angles ``[N]`` in radians."""
    vectors = np.empty((2, len(angles)))
    np.cos(angles, out=vectors[0])
    np.sin(angles, out=vectors[1])
    return vectors
