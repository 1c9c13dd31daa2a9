"""What driving costs: the same law for one robot and for arrays of robots.

A motor works against inertia and against the drag of the floor. Between two readings of a body its
work is the kinetic energy ``m * v * v / 2`` that the body has gained, plus the drag times the
distance, all in joules.

Work can be negative when a robot brakes: the floor then takes the energy of its motion, and the
motor takes the rest. A motor that brakes returns nothing to the battery, or with ``recuperation`` a
share. So negative work counts as 0 or as that share. This is applied to each stretch between two
readings by itself, since otherwise braking would pay for driving.

The battery pays for the work at the wheels, divided by the efficiency of the drivetrain, and for
the computer, whose ``idle_power`` is drawn all the time.

The same law holds for the two wheels of a differential drive while they turn the robot on the spot.
The distance and the speed are then measured at a wheel, and the mass is the one that the wheels
feel in a turn.

Chipmunk moves positions before it changes velocities. A position therefore lags half a substep
behind the mean of the velocities before and after each substep. So the drag is counted over the
distance of a point that is half a substep ahead of the body.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from warehouse_core.world.tables import Integers
from warehouse_physics.profile import Floats, lengths_of, plan_profile
from warehouse_physics.spec import RobotSpec

Amount = TypeVar("Amount", float, Floats)


def kinetic(mass: Amount, right: Amount, down: Amount) -> Amount:
    """Return the kinetic energy in J of a mass in kg with a velocity in m/s."""
    return 0.5 * mass * (right * right + down * down)


def spent(work: Amount) -> Amount:
    """Return the part of some work in J that the motor has done, or 0 if the work is negative."""
    return work * (work > 0)


def regained(spec: RobotSpec, work: Amount) -> Amount:
    """Return the energy in J that the battery gets back from some work, or 0 if it is positive."""
    return spec.recuperation * spec.drivetrain_efficiency * -(work - spent(work))


def paid(spec: RobotSpec, work: Amount) -> Amount:
    """Return the energy in J for which the battery pays: ``spent`` minus ``regained``."""
    return spent(work) - regained(spec, work) if spec.recuperation else spent(work)


def work_in_substep(
    masses: Floats, before: Floats, after: Floats, drags: Floats, time_step: float
) -> Floats:
    """Return the work in J of motors that change speeds in m/s in a substep, all ``[R]``."""
    gained = masses * (after**2 - before**2) / 2
    work: Floats = gained + drags * np.abs(before) * time_step
    return work


class WorkBook:
    """The work of one motor, from one reading of what it moves to the next.

    Attributes:
        place: position at the last reading, in metres along each axis or along a wheel.
        energy: kinetic energy at the last reading, in J.
    """

    __slots__ = ("energy", "place")

    def __init__(self, place: tuple[float, ...], energy: float = 0.0) -> None:
        self.start(place, energy)

    def start(self, place: tuple[float, ...], energy: float = 0.0) -> None:
        """Begin to count with a reading."""
        self.place, self.energy = place, energy

    def until(self, place: tuple[float, ...], energy: float, drag: float) -> float:
        """Return the work in J from the last reading to this one, with a drag in N."""
        return energy - self.energy + drag * math.dist(self.place, place)

    def count(self, place: tuple[float, ...], energy: float, drag: float) -> float:
        """Return the work in J from the last reading to this one, which becomes the last."""
        work = self.until(place, energy, drag)
        self.start(place, energy)
        return work


class WorkBooks:
    """The work of the motors of ``B`` robots; see ``WorkBook``."""

    def __init__(self, robots: int) -> None:
        self._places, self._energies = np.zeros((robots, 2)), np.zeros(robots)

    def start(self, rows: Integers, places: Floats, energies: Floats | float = 0.0) -> None:
        """Begin to count for some rows, with positions ``[N, 2]`` and energies ``[N]``."""
        self._places[rows], self._energies[rows] = places, energies

    def count(self, rows: Integers, places: Floats, energies: Floats, drags: Floats) -> Floats:
        """Return the work ``[N]`` J of some rows from their last readings to these."""
        work: Floats = energies - self._energies[rows]
        work += drags * lengths_of(places - self._places[rows])
        self.start(rows, places, energies)
        return work


def turn_work(spec: RobotSpec, quarters: int, loaded: bool) -> float:
    """Return the work in J of a nominal turn on the spot with differential drive."""
    profile, mass = spec.turn_profile(quarters * math.pi / 2, loaded), spec.turning_mass(loaded)
    speed, dt = profile.velocity[0], spec.time_step
    gained = spec.turning_acceleration(loaded) * dt
    # Positions move before velocities change, so the last speed counts for half a substep.
    distance = float(dt * (np.minimum(np.arange(profile.go) * gained, speed).sum() + speed / 2))
    energy, drag = kinetic(mass, speed, 0.0), spec.drag_force(loaded)
    braked = drag * (speed * dt * profile.go - distance) - energy
    return spent(energy + drag * distance) - regained(spec, braked)


def move_joules(spec: RobotSpec, loaded: bool) -> float:
    """Return the energy in J that the battery loses at most in a free move over one cell.

    The move is nominal, without disturbances. Energy that is recovered is not subtracted.
    """
    acceleration = spec.attainable_acceleration(loaded)
    profile = plan_profile((0.0, 0.0), (spec.cell_size, 0.0), *spec.limits(acceleration))
    work = kinetic(spec.total_mass(loaded), *profile.velocity)
    work += spec.drag_force(loaded) * spec.cell_size
    return joules_of(spec, work, (profile.go + profile.brake) * spec.time_step)


def joules_of(spec: RobotSpec, work: Amount, seconds: Amount | float) -> Amount:
    """Return the energy in J that the battery loses in an action.

    Args:
        spec: numbers of the robot.
        work: work at the wheels, in J.
        seconds: duration of the action, in which the computer uses energy too.
    """
    return work / spec.drivetrain_efficiency + spec.idle_power * seconds
