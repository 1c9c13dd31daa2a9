"""What driving costs: one law for a robot and, in the same arithmetic, for arrays of robots.

A motor works against inertia and against the drag of the floor: between two looks at a body that
is the kinetic energy which it has gained, plus the drag times its way. A body that the floor brakes
pays for the drag out of its own motion, and a motor that brakes feeds nothing back into the
battery, or with recuperation a share. So work below zero counts as none, or as that share, for each
stretch between two looks alone.

The two wheels of a differential drive work by the same law as they turn the robot on the spot: with
the way and the speed of a wheel, and with the mass that wheels feel in a turn.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from warehouse_physics.profile import Floats, plan_profile
from warehouse_physics.spec import RobotSpec

Amount = TypeVar("Amount", float, Floats)


def kinetic(mass: Amount, right: Amount, down: Amount) -> Amount:
    """Return the kinetic energy in J of a mass in kg at a velocity in m/s."""
    return 0.5 * mass * (right * right + down * down)


def spent(work: Amount) -> Amount:
    """Return what some work in J takes from the drive: nothing, if it is below zero."""
    return work * (work > 0)


def regained(spec: RobotSpec, work: Amount) -> Amount:
    """Return what some work in J gives back to the drive: nothing, if it is above zero."""
    return spec.recuperation * spec.drivetrain_efficiency * -(work - spent(work))


def turn_work(spec: RobotSpec, quarters: int, loaded: bool) -> float:
    """Return the work in J of the motors in a nominal turn on the spot with differential drive."""
    profile, mass = spec.turn_profile(quarters * math.pi / 2, loaded), spec.turning_mass(loaded)
    speed, dt = profile.velocity[0], spec.time_step
    gained = spec.turning_acceleration(loaded) * dt
    # Positions move before velocities change; the last speed counts for half a substep.
    way = float(dt * (np.minimum(np.arange(profile.go) * gained, speed).sum() + speed / 2))
    energy, drag = kinetic(mass, speed, 0.0), spec.drag_force(loaded)
    braked = drag * (speed * dt * profile.go - way) - energy
    return spent(energy + drag * way) - regained(spec, braked)


def move_joules(spec: RobotSpec, loaded: bool) -> float:
    """Return what a free move over one cell takes from the battery, at most; nominal, in J."""
    pace = spec.attainable_acceleration(loaded)
    profile = plan_profile((0.0, 0.0), (spec.cell_size, 0.0), *spec.limits(pace))
    work = kinetic(spec.total_mass(loaded), *profile.velocity)
    work += spec.drag_force(loaded) * spec.cell_size
    return joules_of(spec, work, (profile.go + profile.brake) * spec.time_step)


def joules_of(spec: RobotSpec, work: Amount, seconds: Amount | float) -> Amount:
    """Return what work at the wheels, and the computer in the meantime, take from the battery."""
    return work / spec.drivetrain_efficiency + spec.idle_power * seconds
