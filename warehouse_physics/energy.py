"""What driving costs: one law for a robot and, in the same arithmetic, for arrays of robots.

A motor works against inertia and against the drag of the floor: between two looks at a body that
is the kinetic energy which it has gained, plus the drag times its way. A body that the floor brakes
pays for the drag out of its own motion, and a motor that brakes feeds nothing back into the
battery. So work below zero counts as none, for each stretch between two looks alone.
"""

from __future__ import annotations

from typing import TypeVar

from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec

Amount = TypeVar("Amount", float, Floats)


def kinetic(mass: Amount, right: Amount, down: Amount) -> Amount:
    """Return the kinetic energy in J of a mass in kg at a velocity in m/s."""
    return 0.5 * mass * (right * right + down * down)


def spent(work: Amount) -> Amount:
    """Return what some work in J takes from the drive: nothing, if it is below zero."""
    return work * (work > 0)


def joules_of(spec: RobotSpec, work: Amount, seconds: Amount | float) -> Amount:
    """Return what work at the wheels, and the computer in the meantime, take from the battery."""
    return work / spec.drivetrain_efficiency + spec.idle_power * seconds
