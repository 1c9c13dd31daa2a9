"""One robot with two driven wheels: force along its heading only, and turns on the spot.

What is simulated: a solid disc with mass and moment of inertia. Its wheels push it along its
heading, with the motor's force at most, or turn it on the spot, with the same force at the arm of
the wheels. Against a push from the side the tyres hold it on its line. They slip only on slippery
floor, along the heading and sideways, each with up to the grip there. The floor drags at the wheels
in turns too.

What is not: two motors with errors of their own, casters, tyres that scrub in a turn, and arcs.
A robot drives straight on or turns on the spot. On its way to another cell it drives forwards; to
correct itself, and back after a hit, it drives whichever end is nearer first. It turns only where
it would otherwise miss its target. On the usual floor that is before it sets off to another cell,
since nothing gets it off its line.
"""

from __future__ import annotations

import math

import pymunk

from warehouse_core import Cell
from warehouse_physics.arena import Position
from warehouse_physics.energy import kinetic, regained, spent
from warehouse_physics.profile import braking
from warehouse_physics.robot import AT_REST, BRAKE, HELD, REST, Robot, apart
from warehouse_physics.spec import ARRIVED

TURN = HELD + 1
"""Phase of a drive in which the robot speeds up to turn, or turns, on the spot."""

LINE = 100.0
"""Cells from the control body to the ends of the lines on which joints hold a robot."""

SIDEWAYS = 1e-5
"""Least share of a push from the side that counts as along the heading."""


class WheeledRobot(Robot):
    """A robot with differential drive; see ``Robot``."""

    def _drive_joints(self) -> list[pymunk.Constraint]:
        """Make the joints to the control body, which moves and turns as commanded.

        A groove leaves a robot free along a line: across the heading for the wheels that push,
        along it for the tyres that hold.
        """
        reach = LINE * self._spec.cell_size
        across, along = (0.0, reach), (reach, 0.0)
        self._motor, self._tyres = (
            pymunk.GrooveJoint(self._control, self.body, (-x, -y), (x, y), (0, 0))
            for x, y in (across, along)
        )
        self._motor.max_bias = 0.0
        # What a hit adds to the way, as the solver corrects an overlap, is gone a substep later.
        self._tyres.error_bias = 0.0
        self._steering = pymunk.SimpleMotor(self.body, self._control, 0.0)
        self._turn_acceleration = 0.0
        # Where work of turns was last counted: metres that a wheel has driven, and kinetic energy.
        self._turned = self._turn_energy = 0.0
        self._leaves, self._is_to_face = 0, False
        self.phase = REST
        return [self._tyres, self._motor, self._steering]

    def begin(self, displacement: Cell, loaded: bool, pace: float) -> int:
        """Begin an action; see ``Robot.begin``."""
        self._take_line()
        self._is_to_face = displacement != (0, 0)
        return super().begin(displacement, loaded, pace)

    def set_off(self, turning: int) -> None:
        """Turn, wait until so many substeps have passed, and drive off; or stay."""
        if self.action.goal != self.action.home:
            self._leaves = turning
            self.action.deadline += turning
            self.drive(0, self.action.target)

    def turn_to(self, direction: Cell) -> None:
        """Turn on the spot in an action that stays in its cell; see ``Robot.turn_to``."""
        self._leaves = 0
        self._turn_by(0, math.remainder(math.atan2(*direction) - self.body.angle, math.tau))

    def next_phase(self, now: int) -> None:
        """Start the phase that is due at substep ``now``."""
        rim = abs(self.body.angular_velocity) * self._spec.wheel_arm
        if self.phase == BRAKE and self._spec.recuperation:
            self.action.work -= regained(self._spec, self._worked_in_turn())
        if self.phase == TURN:
            self._brake(now, max(self._braking, self._leaves - now))
        elif self.phase == BRAKE and rim > AT_REST:
            rate = max(
                self._spec.turning_acceleration(self._loaded), self._drag / self._turning_mass
            )
            self._brake(now, braking(rim, rate, self._spec.time_step))
        else:
            super().next_phase(now)

    def drive(
        self, now: int, waypoint: Position, share: float = 1.0, *, is_hard: bool = False
    ) -> None:
        """Drive to a position, or turn on the spot where it would otherwise be missed.

        See ``Robot.drive`` for ``share`` and ``is_hard``.
        """
        angle = self._angle_to(waypoint)
        has_turned = self._control.angle != self.body.angle
        if angle or has_turned or self._slips:
            self._take_line()
        if angle:
            self._turn_by(now, angle)
        elif now < self._leaves:
            self._brake(now, self._leaves - now)
        else:
            self._is_to_face = False
            right, down = self._driven(pymunk.Vec2d(*apart(waypoint, self.position)))
            super().drive(
                now, (self.position[0] + right, self.position[1] + down), share, is_hard=is_hard
            )

    def has_arrived(self) -> bool:
        """Return whether the robot was at its target at the last look."""
        off = math.dist(self._place(), self.action.target)
        return off <= ARRIVED * self._spec.cell_size

    def mass_along(self, normal: Position) -> float:
        """Return the mass in kg with which the robot resists a push along ``normal``.

        Where tyres hold, it can only give way along its heading.
        """
        if self._slips:
            return self._mass
        return mass_on_line(self._mass, self._driven(pymunk.Vec2d(*normal)).length)

    def feel_floor(self) -> None:
        """Update drag and grip where the floor differs from cell to cell."""
        before = self._on
        super().feel_floor()
        if self._on != before:
            self._hold()

    def _turn_towards(self, displacement: Cell) -> int:
        """Return the substeps that the robot has to turn before it drives to its target."""
        angle = self._angle_to(self.action.target)
        if not angle:
            return 0
        profile = self._spec.turn_profile(angle, self._loaded)
        return profile.go + profile.brake

    def _angle_to(self, waypoint: Position) -> float:
        """Return the radians to turn before driving to a position, or 0 if that is not needed."""
        right, down = apart(waypoint, self._place())
        angle = math.remainder(math.atan2(down, right) - self.body.angle, math.tau)
        if self.action.gave_up or not self._is_to_face:
            angle = math.remainder(angle, math.pi)
        misses = abs(math.sin(angle)) * math.hypot(right, down)
        is_ahead = abs(angle) <= math.pi / 2
        return 0.0 if is_ahead and misses <= ARRIVED * self._spec.cell_size / 2 else angle

    def _turn_by(self, now: int, angle: float) -> None:
        spec = self._spec
        profile = spec.turn_profile(angle, self._loaded)
        if self._uneven is not None:
            profile = profile.scaled(self._uneven.speed_factor())
        self._brake(now, 0)
        self._worked_in_turn()
        self._control.angular_velocity = profile.velocity[0] / spec.wheel_arm
        pace = spec.turning_acceleration(self._loaded)
        wanted = min(self._turning_mass * pace + self._nominal_drag, self._limit())
        self._steering.max_force = spec.wheel_arm * max(wanted - self._drag, 0.0)
        self.phase, self.until, self._braking = TURN, now + profile.go, profile.brake

    def _brake(self, now: int, substeps: int) -> None:
        if self.phase == TURN:
            self.action.work += spent(self._worked_in_turn())
        self._control.angular_velocity = 0.0
        pace = self._spec.turning_acceleration(self._loaded)
        wanted = max(self._turning_mass * pace - self._nominal_drag, 0.0)
        force = min(wanted, self._limit()) + self._drag
        self._steering.max_force = self._spec.wheel_arm * force
        super()._brake(now, substeps)

    def _limit(self) -> float:
        """Return the largest force in N with which the wheels can push in this cell."""
        if self._uneven is None:
            return math.inf
        return self._uneven.force_limit(self._on, self._spec.motor_force, self._mass)

    def _worked_in_turn(self) -> float:
        """Return the work of the motors in turns since the last count.

        Work is counted at the wheels: kinetic energy gained, plus the drag on their way.
        """
        start, energy = self._turned, self._turn_energy
        rim = self.body.angular_velocity * self._spec.wheel_arm
        self._turned = self.body.angle * self._spec.wheel_arm + self._lead * rim
        self._turn_energy = kinetic(self._turning_mass, rim, 0.0)
        return self._turn_energy - energy + self._drag * abs(self._turned - start)

    def _count_from(self, velocity: pymunk.Vec2d, lead: float) -> None:
        """Begin to count work at this position; sideways ``velocity`` is none of the wheels'."""
        super()._count_from(self._driven(velocity), lead)

    def _driven(self, vector: pymunk.Vec2d) -> pymunk.Vec2d:
        """Return the part of a vector that is along the heading."""
        heading = pymunk.Vec2d.from_polar(1.0, self.body.angle)
        return heading * heading.dot(vector)

    def _load(self, loaded: bool, pace: float) -> None:
        """Set the load, and the acceleration in m/s² to drive with."""
        self._turning_mass = self._spec.turning_mass(loaded)
        super()._load(loaded, pace)
        self._hold()

    def _hold(self) -> None:
        """Let tyres hold the robot on its line as firmly as the floor here allows.

        The drag of the floor already resists sideways too.
        """
        force = math.inf
        if self._uneven is not None:
            force = max(self._uneven.grip_force(self._on, self._mass) - self._drag, 0.0)
        self._slips = force < math.inf
        self._tyres.max_force, self._tyres.max_bias = force, 0.0 if self._slips else math.inf
        self._take_line()

    def _take_line(self) -> None:
        """Let the lines of the joints lead through the robot, along its heading and across."""
        self._control.position, self._control.angle = self.body.position, self.body.angle

    def _place(self) -> Position:
        """Return where the robot is, on its line where tyres hold.

        The solver moves robots that overlap off their lines, for a substep.
        """
        if self._slips:
            return self.position
        line = self._control.position
        return line + self._driven(self.body.position - line)


def mass_on_line(mass: float, share: float) -> float:
    """Return the mass in kg with which a robot resists a push if it can only move along a line.

    The ``share`` of the push is along the line, -1 to 1.
    """
    return mass / max(share * share, SIDEWAYS**2)
