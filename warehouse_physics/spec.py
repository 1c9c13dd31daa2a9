"""The numbers of a robot, checked before pymunk sees them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from warehouse_core.arguments import one_of, real_number, settle
from warehouse_core.motion.grid import GRAVITY
from warehouse_core.wording import brief
from warehouse_physics.profile import Profile, plan_profile

OMNIDIRECTIONAL, DIFFERENTIAL = "omnidirectional", "differential"

ACCURATE_STEP, FAST_STEP = 1 / 60, 1 / 30
"""Substeps in seconds; with the fast one a robot sinks deeper into a wall that it hits."""

MIN_VALUE, MAX_VALUE = 1e-9, 1e9
"""Limits of every value in its unit, but that some may be 0; products of such values are finite."""

ARRIVED = 1e-3
"""Share of a cell within which a robot has arrived at its target."""

MAX_FLEET_RADIUS = 0.4
"""Share of a cell that the radius ``r`` of one of several robots may have. Two that follow each
other round a corner come within ``sqrt(1 / 2)`` of a cell on their lines. Wider ones push each
other outward, up to the walls: then they are ``sqrt(2) * (1 - r)`` apart, which is ``2 * r`` at
0.414."""

MAX_WHEELED_RADIUS = 0.35
"""The same with differential drive. Two wheels hold a robot on its line, so that those which turn
the same corner cannot push each other outward: they have to get past untouched."""

MIN_TRACK = 0.1
"""Share of the diameter that the distance between the wheels has at least."""

MARGIN = 1e-6
"""Share by which a body is smaller than its robot; and of a substep, which rounding may add."""

MAX_MOVE_SUBSTEPS = 2_000
"""Substeps that a free move may take, 33 s at 1/60 s."""


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A small warehouse robot, in SI units.

    Attributes:
        radius: radius of the round body, metres. Two robots that turn the same corner one after the
            other come within 0.707 of a cell, so with more than 0.35 of a cell they touch; with
            more than ``MAX_FLEET_RADIUS`` of it they do not get past, and there can be only one.
        mass: mass without a load, kg; about 70 for a MiR100.
        payload_mass: mass of an item, kg.
        top_speed: highest speed, m/s; near people 1 to 1.5 m/s (MiR100: 1.5).
        acceleration: nominal acceleration, also for braking, m/s².
        motor_force: force of the motor, N. Where it is too small for a load, the acceleration is
            lower.
        floor_drag: rolling force over weight; 0.01 to 0.02 for a hard tyre on concrete. Where
            it brakes harder than the robot accelerates, robots stop by it alone.
        drivetrain_efficiency: work at the wheel over energy from the battery, above 0, up to 1.
        idle_power: power of computer and sensors, W.
        recuperation: share of the work of a braking motor that gets back into the battery, 0 to 1;
            turns that take ``turn_seconds`` give none back.
        dwell: duration of waiting, picking and dropping, seconds.
        turn_seconds: duration of a quarter turn on the spot, seconds. A robot with two driven
            wheels turns before it drives in another direction; a half turn takes twice as long.
            With 0 it drives in any direction without turning. A MiR100 takes about 1.6 (1.5 rad/s
            and 2.5 rad/s², ``diffdrive_controller.yaml`` of github.com/DFKI-NI/mir_robot). A turn
            costs the idle power only. It must be 0 with differential drive, whose turns take what
            its wheels need.
        cell_size: side of a cell, metres.
        time_step: duration of a physics substep, seconds.
        drive: ``"omnidirectional"``, a disc that is pushed in any direction; or
            ``"differential"``, two driven wheels that push along the heading only. To turn on the
            spot one wheel drives forwards and the other backwards, with the speed, acceleration
            and motor force of a drive, against the moment of inertia of a solid disc and the drag
            of the floor. A quarter turn of the default robot takes 1.25 s and 11 J at the wheels.
        track: distance between the two wheels over the diameter of the body, ``MIN_TRACK`` to 1;
            only differential drive uses it.

    Raises:
        ValueError: naming the field, its value and what is allowed.

    Example:
        >>> from warehouse_physics import RobotSpec
        >>> spec = RobotSpec(mass=70.0)
        >>> round(spec.move_seconds(loaded=False), 2), round(spec.move_seconds(loaded=True), 2)
        (2.37, 2.77)
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
    turn_seconds: float = 0.0
    cell_size: float = 1.0
    time_step: float = ACCURATE_STEP
    drive: str = OMNIDIRECTIONAL
    track: float = 0.7
    recuperation: float = 0.0

    def __post_init__(self) -> None:
        may_be_zero = {"payload_mass", "floor_drag", "idle_power", "turn_seconds"}
        shares = {"drivetrain_efficiency": MIN_VALUE, "track": MIN_TRACK, "recuperation": 0.0}
        one_of("drive", self.drive, (OMNIDIRECTIONAL, DIFFERENTIAL))
        for each in fields(self):
            if each.name == "drive":
                continue
            maximum = 1.0 if each.name in shares else MAX_VALUE
            minimum = 0.0 if each.name in may_be_zero else shares.get(each.name, MIN_VALUE)
            value = real_number(each.name, getattr(self, each.name), minimum, maximum)
            settle(self, **{each.name: value})
        self._check_together()

    def _check_together(self) -> None:
        # A robot that has arrived, as far off the middle as ``ARRIVED`` allows, touches no wall.
        widest = (0.5 - ARRIVED) * self.cell_size
        if self.radius > widest:
            raise ValueError(
                f"radius is {self.radius!r}; with cell_size {self.cell_size!r} it must be at most "
                f"{widest!r}"
            )
        # A body that moves farther than its radius in a substep could pass through a wall.
        fastest = self.radius / 2 / self.time_step
        if self.top_speed > fastest:
            raise ValueError(
                f"top_speed is {self.top_speed!r}; with time_step {self.time_step!r} and radius "
                f"{self.radius!r} it must be at most {fastest!r}"
            )
        pace = self.attainable_acceleration(loaded=True)
        if pace <= 0:
            raise ValueError(
                f"motor_force is {self.motor_force!r}; to move the loaded robot it must be above "
                f"{self.drag_force(loaded=True)!r}"
            )
        if self.is_differential and self.turn_seconds:
            raise ValueError(
                f"turn_seconds is {self.turn_seconds!r}; it must be 0 with drive {self.drive!r}, "
                "whose turns take what its wheels need"
            )
        # The longest free move is that of a loaded robot that first turns round.
        turning = 2 * self.turn_seconds
        if self.is_differential:
            turning = self._seconds_over(math.pi * self.wheel_arm, *self._turning(loaded=True))
        seconds = turning + self.move_seconds(loaded=True)
        substeps = seconds / self.time_step
        if substeps > MAX_MOVE_SUBSTEPS:
            raise ValueError(
                f"time_step is {self.time_step!r}; the loaded robot would take {substeps:.4g} of "
                f"them to the cell behind it and it must be at most {MAX_MOVE_SUBSTEPS}"
            )

    @classmethod
    def fast(cls) -> RobotSpec:
        """Return the default robot with the fast substep."""
        return replace(cls(), time_step=FAST_STEP)

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, Any], others: Sequence[str] = ()) -> RobotSpec:
        """Return the default robot with other numbers, or another drive.

        ``others`` are names of numbers that are allowed too where these were read.

        Raises:
            ValueError: there is no such number, or it is out of range.
        """
        allowed = [each.name for each in fields(cls)]
        for name in numbers:
            if name not in allowed:
                known = ", ".join([*allowed, *others])
                raise ValueError(f"no number is called {brief(name)}; allowed: {known}")
        return cls(**numbers)

    @property
    def body_radius(self) -> float:
        """The radius of the body in the space, in metres: slightly smaller than ``radius``.

        With round numbers a touch would often fall exactly on a substep, and rounding would decide
        in which one it is noticed.
        """
        return self.radius * (1 - MARGIN)

    def total_mass(self, loaded: bool) -> float:
        """Return the mass in kg with or without an item."""
        return self.mass + (self.payload_mass if loaded else 0.0)

    def drag_force(self, loaded: bool) -> float:
        """Return the drag of the floor on a moving robot in N."""
        return self.floor_drag * self.total_mass(loaded) * GRAVITY

    @property
    def turns_on_the_spot(self) -> bool:
        """Whether the robot stops to turn."""
        return self.is_differential or self.turn_seconds > 0

    @property
    def is_differential(self) -> bool:
        """Whether the robot has two driven wheels."""
        return self.drive == DIFFERENTIAL

    @property
    def wheel_arm(self) -> float:
        """The distance of a wheel from the middle of the robot in metres."""
        return self.track * self.radius

    def turning_mass(self, loaded: bool) -> float:
        """Return the mass in kg that the wheels feel as the robot turns on the spot.

        The moment of inertia of a solid disc, over the square of ``wheel_arm``, is such a mass.
        """
        return self.total_mass(loaded) / (2 * self.track**2)

    def turn_substeps(self, quarters: int, loaded: bool = False) -> int:
        """Return the substeps of so many quarter turns on the spot."""
        if self.is_differential:
            profile = self.turn_profile(quarters * math.pi / 2, loaded)
            return profile.go + profile.brake if quarters else 0
        return math.ceil(quarters * self.turn_seconds / self.time_step - MARGIN)

    def turn_profile(self, angle: float, loaded: bool) -> Profile:
        """Return how a wheel drives to turn the robot on the spot by ``angle`` radians.

        The first part of the velocity is the speed of the wheel in m/s, below 0 to the left.
        """
        pace, drag = self._turning(loaded)
        way = self.wheel_arm * angle, 0.0
        return plan_profile((0.0, 0.0), way, self.top_speed, pace, self.time_step, drag)

    def move_seconds(self, loaded: bool) -> float:
        """Return the nominal duration of a free move over one cell in seconds."""
        pace = self.attainable_acceleration(loaded)
        return self._seconds_over(self.cell_size, pace, self.floor_deceleration)

    def _seconds_over(self, way: float, pace: float, drag: float) -> float:
        """Return the nominal seconds from rest to rest over a way in metres."""
        brake = max(pace, drag)
        speed = min(self.top_speed, math.sqrt(2 * pace * way / (1 + pace / brake)))
        return way / speed + speed / pace * (1 + pace / brake) / 2

    def limits(self, pace: Any, share: float = 1.0) -> tuple[float, Any, float, float]:
        """Return what limits a profile: top speed, acceleration, time step and drag.

        The acceleration is ``pace``, one or an array, and the speed a share of the usual one.
        """
        return self.top_speed * share, pace, self.time_step, self.floor_deceleration

    @property
    def floor_deceleration(self) -> float:
        """How fast a robot that rolls freely slows down, in m/s², loaded or not."""
        return self.floor_drag * GRAVITY

    def attainable_acceleration(self, loaded: bool) -> float:
        """Return the nominal acceleration in m/s², or what the motor reaches if that is less."""
        return min(self.acceleration, self.greatest_acceleration(loaded))

    def greatest_acceleration(self, loaded: bool) -> float:
        """Return the acceleration in m/s² that the motor can reach.

        Top speed is never reached in less than a substep; otherwise the motor could push a robot
        into a wall harder than the rounds of the solver can correct.
        """
        return self._greatest(loaded, self.total_mass(loaded))

    def turning_acceleration(self, loaded: bool) -> float:
        """Return ``attainable_acceleration`` for wheels as the robot turns on the spot."""
        return min(self.acceleration, self._greatest(loaded, self.turning_mass(loaded)))

    def _greatest(self, loaded: bool, mass: float) -> float:
        spare = self.motor_force - self.drag_force(loaded)
        return min(spare / mass, self.top_speed / self.time_step)

    def _turning(self, loaded: bool) -> tuple[float, float]:
        """Return how fast wheels speed up and the floor slows them down on the spot, in m/s²."""
        drag = self.drag_force(loaded) / self.turning_mass(loaded)
        return self.turning_acceleration(loaded), drag
