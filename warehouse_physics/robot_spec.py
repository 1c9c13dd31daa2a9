"""What a robot is made of: every number of the physics, checked before pymunk sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

GRAVITY = 9.81
"""Metres per second squared."""

ACCURATE_STEP, FAST_STEP = 1 / 60, 1 / 30
"""Substeps in seconds; the fast one lets a robot sink deeper into a wall that it hits."""

LARGEST = 1e9
"""What no value exceeds, in its unit; products of such values are still finite."""

ARRIVED = 1e-3
"""Share of a cell within which a robot is where it wants to be."""

MOST_LEG_SUBSTEPS = 2_000
"""Substeps that a free move may take, 33 s at 1/60 s."""


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A small warehouse robot. All units are SI.

    Attributes:
        radius: of its round body, metres. Two robots that take the same corner one after the
            other come within 0.707 of a cell, so more than 0.35 of a cell makes them touch.
        mass: without a load, kg. Small commercial robots have 50 to 70 kg (MiR100: about 70).
        payload_mass: of an item, kg.
        top_speed: m/s. Beside people robots drive 1 to 1.5 m/s (MiR100: 1.5).
        acceleration: that the drive asks for, m/s², braking too.
        motor_force: that the motor has, N. A load that makes it too little lowers the
            acceleration.
        floor_drag: rolling force over weight; a hard tyre on concrete has 0.01 to 0.02.
        drivetrain_efficiency: work at the wheel over energy from the battery, above 0, up to 1.
        idle_power: of computer and sensors, W.
        dwell: how long waiting, picking and dropping take, seconds.
        cell_size: side of a cell, metres.
        time_step: of a physics substep, seconds.

    Raises:
        ValueError: naming the field, its value and what is allowed.
    """

    radius: float = 0.35
    mass: float = 50.0
    payload_mass: float = 20.0
    top_speed: float = 1.0
    acceleration: float = 1.0
    motor_force: float = 60.0
    floor_drag: float = 0.015
    drivetrain_efficiency: float = 0.8
    idle_power: float = 20.0
    dwell: float = 1.0
    cell_size: float = 1.0
    time_step: float = ACCURATE_STEP

    def __post_init__(self) -> None:
        may_be_zero = {"payload_mass", "floor_drag", "idle_power"}
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise ValueError(f"{each.name} is {value!r}; it must be a number")
            # Written so that NaN, which compares false with anything, is refused too.
            if not 0 <= value <= LARGEST or (value == 0 and each.name not in may_be_zero):
                least = "at least 0" if each.name in may_be_zero else "above 0"
                raise ValueError(
                    f"{each.name} is {value!r}; it must be {least} and at most {LARGEST:g}"
                )
        self._check_together()

    def _check_together(self) -> None:
        if self.drivetrain_efficiency > 1:
            raise ValueError(
                f"drivetrain_efficiency is {self.drivetrain_efficiency!r}; it must be at most 1"
            )
        # Where it stands off the middle by as much as passes for arrived it must touch no wall.
        largest = (0.5 - ARRIVED) * self.cell_size
        if self.radius > largest:
            raise ValueError(
                f"radius is {self.radius!r}; with cell_size {self.cell_size!r} it must be at most "
                f"{largest!r}"
            )
        # A body that moves further than its radius in a substep could pass through a wall.
        fastest = self.radius / 2 / self.time_step
        if self.top_speed > fastest:
            raise ValueError(
                f"top_speed is {self.top_speed!r}; with time_step {self.time_step!r} and radius "
                f"{self.radius!r} it must be at most {fastest!r}"
            )
        if self.attainable_acceleration(loaded=True) <= 0:
            raise ValueError(
                f"motor_force is {self.motor_force!r}; to move the loaded robot it must be above "
                f"{self.drag_force(loaded=True)!r}"
            )
        substeps = self._slowest_move() / self.time_step
        if substeps > MOST_LEG_SUBSTEPS:
            raise ValueError(
                f"time_step is {self.time_step!r}; the loaded robot would take {substeps:.4g} of "
                f"them for one cell and it must be at most {MOST_LEG_SUBSTEPS}"
            )

    def _slowest_move(self) -> float:
        """Return the seconds that a free move takes with a load."""
        pace = self.attainable_acceleration(loaded=True)
        speed = min(self.top_speed, math.sqrt(pace * self.cell_size))
        return self.cell_size / speed + speed / pace

    @classmethod
    def fast(cls) -> RobotSpec:
        """Return the default robot with the fast substep."""
        return replace(cls(), time_step=FAST_STEP)

    def total_mass(self, loaded: bool) -> float:
        """Return the mass in kg with or without an item."""
        return self.mass + (self.payload_mass if loaded else 0.0)

    def drag_force(self, loaded: bool) -> float:
        """Return the force in N that the floor takes from a moving robot."""
        return self.floor_drag * self.total_mass(loaded) * GRAVITY

    def attainable_acceleration(self, loaded: bool) -> float:
        """Return what the drive asks for or, where that is less, what the motor can give.

        No drive needs to reach top speed in less than a substep; one that could would push a
        robot into a wall harder than the rounds of the solver can make up for.
        """
        spare = self.motor_force - self.drag_force(loaded)
        at_once = self.top_speed / self.time_step
        return min(self.acceleration, spare / self.total_mass(loaded), at_once)
