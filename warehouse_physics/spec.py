"""The numbers that describe a robot, checked before pymunk uses them."""

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

ACCURATE_STEP, FAST_STEP = 1 / 60, 1 / 32
"""Substeps in seconds. Moves take a whole number of substeps, so that they are rounded up more with
the fast one. It is about the longest that ``refined`` leaves as it is for the default robot."""

MIN_VALUE, MAX_VALUE = 1e-9, 1e9
"""Limits of each value in its unit; some may also be 0. Products of such values are finite."""

ARRIVED = 1e-3
"""Distance to the target at which a robot has arrived, as a share of a cell."""

MAX_FLEET_RADIUS = 0.4
"""Largest radius ``r`` of a robot that is not alone, as a share of a cell. Two robots that follow
each other round a corner come within ``sqrt(1 / 2)`` of a cell of each other. Wider robots push
each other outwards, up to the walls. They are then ``sqrt(2) * (1 - r)`` apart, which equals ``2 *
r`` for a radius of 0.414."""

MAX_WHEELED_RADIUS = 0.35
"""Largest radius of a robot with differential drive that is not alone, as a share of a cell. Its
wheels hold it on its line, so two robots that follow each other round a corner cannot push each
other outwards. They have to pass without touching."""

MIN_TRACK = 0.1
"""Smallest distance between the wheels, as a share of the diameter."""

MARGIN = 1e-6
"""Share by which a body is smaller than its robot; also the share of a substep that rounding may
add."""

DEEPEST = 0.0495
"""Limit on the distance of a substep before a hit, as a share of the radius. A robot then sinks
into a wall by less than 5% of its radius."""

MAX_MOVE_SECONDS = 60.0
"""Longest duration of a free move in seconds."""

MIN_TIME_STEP = 1e-5
"""Shortest substep in seconds. The longest move then takes some seconds to simulate."""


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A small warehouse robot, in SI units.

    Attributes:
        radius: radius of the round body in metres. Two robots that turn the same corner one after
            the other come within 0.707 of a cell of each other. Above 0.35 of a cell they touch.
            Above ``MAX_FLEET_RADIUS`` of a cell they cannot get past each other, so such a robot
            has to be alone.
        mass: mass without an item, kg. A MiR100 has about 70.
        payload_mass: mass of an item, kg.
        top_speed: highest speed, m/s. Near people 1 to 1.5 m/s are common (MiR100: 1.5).
        acceleration: nominal rate of speeding up and of braking, m/s².
        motor_force: largest force of the motor, N. If it is too small for a loaded robot, that
            robot accelerates more slowly.
        floor_drag: rolling resistance as a share of the weight; 0.01 to 0.02 for a hard tyre on
            concrete. If the floor alone brakes harder than the robot accelerates, the robot stops
            without its motor.
        drivetrain_efficiency: work at the wheels per energy from the battery, above 0 and up to 1.
        idle_power: power of computer and sensors, W.
        recuperation: share of the work of a braking motor that returns to the battery, 0 to 1.
            Turns that take ``turn_seconds`` return nothing.
        dwell: duration of waiting, picking and dropping, seconds.
        turn_seconds: duration of a quarter turn on the spot, seconds; a half turn takes twice as
            long. The robot turns before it drives in another direction. With 0 it drives in any
            direction without turning. A turn costs the idle power only. A MiR100 takes about 1.6 s
            (1.5 rad/s and 2.5 rad/s², ``diffdrive_controller.yaml`` of
            github.com/DFKI-NI/mir_robot). Must be 0 with differential drive, where the duration of
            a turn follows from the motor.
        cell_size: side of a cell, metres.
        time_step: longest duration of a physics substep, seconds, at least ``MIN_TIME_STEP``. A
            robot that is fast for its size takes shorter ones; see ``refined``.
        drive: ``"omnidirectional"``, a disc that is pushed in any direction; or ``"differential"``,
            two driven wheels that push along the heading only. To turn on the spot, one wheel
            drives forwards and the other one backwards. They have the same speed, acceleration and
            force as in a drive, and work against the drag of the floor and the moment of inertia of
            a solid disc. A quarter turn of the default robot takes 1.25 s and 11 J at the wheels.
        track: distance between the two wheels as a share of the diameter, ``MIN_TRACK`` to 1. Only
            differential drive uses it.

    Raises:
        ValueError: a value is out of range; the message has the field, the value and what is
            allowed.

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
        lowest = shares | {"time_step": MIN_TIME_STEP}
        one_of("drive", self.drive, (OMNIDIRECTIONAL, DIFFERENTIAL))
        for each in fields(self):
            if each.name == "drive":
                continue
            maximum = 1.0 if each.name in shares else MAX_VALUE
            minimum = 0.0 if each.name in may_be_zero else lowest.get(each.name, MIN_VALUE)
            value = real_number(each.name, getattr(self, each.name), minimum, maximum)
            settle(self, **{each.name: value})
        self._check_together()

    def _check_together(self) -> None:
        # A robot that has arrived may be off the middle by ``ARRIVED``, and must touch no wall.
        widest = (0.5 - ARRIVED) * self.cell_size
        if self.radius > widest:
            raise ValueError(
                f"radius is {self.radius!r}; with cell_size {self.cell_size!r} it must be at most "
                f"{widest!r}"
            )
        # A body that moves farther than its radius in a substep could pass through a wall. Noise
        # may double the speed, so only half of the radius is allowed.
        fastest = self.radius / 2 / self.time_step
        if self.top_speed > fastest:
            raise ValueError(
                f"top_speed is {self.top_speed!r}; with time_step {self.time_step!r} and radius "
                f"{self.radius!r} it must be at most {fastest!r}"
            )
        acceleration = self.attainable_acceleration(loaded=True)
        if acceleration <= 0:
            raise ValueError(
                f"motor_force is {self.motor_force!r}; to move the loaded robot it must be above "
                f"{self.drag_force(loaded=True)!r}"
            )
        if self.is_differential and self.turn_seconds:
            raise ValueError(
                f"turn_seconds is {self.turn_seconds!r}; it must be 0 with drive {self.drive!r}, "
                "whose motor decides how long a turn takes"
            )
        # The longest free move is made by a loaded robot that first turns by half a turn.
        turning = 2 * self.turn_seconds
        if self.is_differential:
            turning = self._seconds_over(math.pi * self.wheel_arm, *self._turning(loaded=True))
        seconds = turning + self.move_seconds(loaded=True)
        if seconds > MAX_MOVE_SECONDS:
            raise ValueError(
                f"the loaded robot would need {seconds:.4g} s to turn and drive one cell, with "
                f"cell_size {self.cell_size!r}, top_speed {self.top_speed!r}, acceleration "
                f"{self.acceleration!r}, motor_force {self.motor_force!r}, payload_mass "
                f"{self.payload_mass!r} and turn_seconds {self.turn_seconds!r}; allowed: at most "
                f"{MAX_MOVE_SECONDS:g} s"
            )

    @classmethod
    def fast(cls) -> RobotSpec:
        """Return the default robot with the fast substep."""
        return replace(cls(), time_step=FAST_STEP)

    @classmethod
    def from_numbers(cls, numbers: Mapping[str, Any], others: Sequence[str] = ()) -> RobotSpec:
        """Return the default robot with some of its numbers, or its drive, replaced.

        ``others`` are further names that are allowed where the numbers come from, for the error
        message.

        Raises:
            ValueError: a name is unknown, or a number is out of range.
        """
        allowed = [each.name for each in fields(cls)]
        for name in numbers:
            if name not in allowed:
                known = ", ".join([*allowed, *others])
                raise ValueError(f"no number is called {brief(name)}; allowed: {known}")
        return cls(**numbers)

    def refined(self, speed: float | None = None) -> RobotSpec:
        """Return this robot with substeps so short that it does not sink deep into walls.

        Chipmunk notices a hit at the end of a substep. In the last one before the hit, a robot must
        therefore drive no farther than the share ``DEEPEST`` of its radius. ``speed`` is the
        highest one at which it may hit a wall in m/s. By default, it is the speed that the robot
        reaches between the middle of its cell and the wall.
        """
        if speed is None:
            room = (0.5 + 2 * ARRIVED) * self.cell_size - self.radius
            acceleration = self.attainable_acceleration(loaded=False)
            speed = min(self.top_speed, math.sqrt(2 * acceleration * room))
        parts = math.ceil(speed * self.time_step / (DEEPEST * self.radius) - MARGIN)
        return self if parts <= 1 else replace(self, time_step=self.time_step / parts)

    @property
    def body_radius(self) -> float:
        """The radius of the body in the space in metres, which is slightly smaller than ``radius``.

        With round numbers a contact would often begin exactly at the end of a substep, and rounding
        would decide in which substep it is noticed.
        """
        return self.radius * (1 - MARGIN)

    def total_mass(self, loaded: bool) -> float:
        """Return the mass in kg, with or without an item."""
        return self.mass + (self.payload_mass if loaded else 0.0)

    def drag_force(self, loaded: bool) -> float:
        """Return the drag of the floor on a moving robot, in N."""
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
        """The distance from the middle of the robot to a wheel, in metres."""
        return self.track * self.radius

    def turning_mass(self, loaded: bool) -> float:
        """Return the mass in kg that the wheels feel while the robot turns on the spot.

        It is the moment of inertia of a solid disc divided by the square of ``wheel_arm``.
        """
        return self.total_mass(loaded) / (2 * self.track**2)

    def turn_substeps(self, quarters: int, loaded: bool = False) -> int:
        """Return the substeps that a number of quarter turns on the spot takes."""
        if self.is_differential:
            profile = self.turn_profile(quarters * math.pi / 2, loaded)
            return profile.go + profile.brake if quarters else 0
        return math.ceil(quarters * self.turn_seconds / self.time_step - MARGIN)

    def turn_profile(self, angle: float, loaded: bool) -> Profile:
        """Return the profile of a wheel that turns the robot on the spot by ``angle`` radians.

        The first component of the velocity is the speed of the wheel in m/s, negative for turns to
        the left.
        """
        acceleration, drag = self._turning(loaded)
        rim = self.wheel_arm * angle, 0.0
        return plan_profile((0.0, 0.0), rim, self.top_speed, acceleration, self.time_step, drag)

    def move_seconds(self, loaded: bool) -> float:
        """Return the nominal duration in seconds of a free move over one cell."""
        acceleration = self.attainable_acceleration(loaded)
        return self._seconds_over(self.cell_size, acceleration, self.floor_deceleration)

    def _seconds_over(self, length: float, acceleration: float, drag: float) -> float:
        """Return the nominal seconds from rest to rest over a length in metres."""
        brake = max(acceleration, drag)
        speed = min(
            self.top_speed, math.sqrt(2 * acceleration * length / (1 + acceleration / brake))
        )
        return length / speed + speed / acceleration * (1 + acceleration / brake) / 2

    def limits(self, acceleration: Any, share: float = 1.0) -> tuple[float, Any, float, float]:
        """Return the limits of a profile: top speed, acceleration, time step and drag.

        ``acceleration`` in m/s² may be a number or an array. The speed is a ``share`` of the top
        speed.
        """
        return self.top_speed * share, acceleration, self.time_step, self.floor_deceleration

    @property
    def floor_deceleration(self) -> float:
        """The rate in m/s² at which the floor slows down a robot that rolls freely."""
        return self.floor_drag * GRAVITY

    def attainable_acceleration(self, loaded: bool) -> float:
        """Return the nominal acceleration in m/s², or less if the motor is too weak for it."""
        return min(self.acceleration, self.greatest_acceleration(loaded))

    def greatest_acceleration(self, loaded: bool) -> float:
        """Return the highest acceleration in m/s² that the motor can reach.

        It is limited so that the robot takes at least one substep to reach its top speed. Otherwise
        the motor could push a robot into a wall harder than the solver can correct.
        """
        return self._greatest(loaded, self.total_mass(loaded))

    def turning_acceleration(self, loaded: bool) -> float:
        """Return the acceleration of a wheel in m/s² while the robot turns on the spot."""
        return min(self.acceleration, self._greatest(loaded, self.turning_mass(loaded)))

    def _greatest(self, loaded: bool, mass: float) -> float:
        spare = self.motor_force - self.drag_force(loaded)
        return min(spare / mass, self.top_speed / self.time_step)

    def _turning(self, loaded: bool) -> tuple[float, float]:
        """Return the rates in m/s² at which a wheel speeds up and at which the floor slows it down.

        Both are for turns on the spot.
        """
        drag = self.drag_force(loaded) / self.turning_mass(loaded)
        return self.turning_acceleration(loaded), drag
