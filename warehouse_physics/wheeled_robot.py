"""One robot with two driven wheels: force along its heading only, and turns on the spot.

*What is simulated.* The robot is a solid disc with mass and moment of inertia. Its wheels push it
along its heading with at most the force of the motor, or turn it on the spot with the same force at
the distance ``wheel_arm`` from the middle. Its tyres hold it on its line against pushes from the
side. They slip only on slippery floor, where the grip limits the force along the heading and the
force to the side. In turns the drag of the floor acts at the wheels.

*Not simulated* are errors of individual motors, casters, tyres that scrub in turns, and driving
along curves. A robot drives straight on or turns on the spot. To another cell it drives
forwards. To correct its position, or to return after a hit, it drives forwards or backwards,
whichever needs the smaller turn. It turns only where it would otherwise miss its target. On floor
that is not slippery this happens only before it sets off to another cell, since nothing moves it
off its line.
"""

from __future__ import annotations

import math

import pymunk

from warehouse_core import Cell
from warehouse_physics.arena import Position
from warehouse_physics.energy import WorkBook, kinetic, regained, spent
from warehouse_physics.phases import AT_REST, BRAKE, REST, TURN
from warehouse_physics.profile import braking
from warehouse_physics.robot import Robot, forces, offset
from warehouse_physics.spec import ARRIVED

LINE = 100.0
"""Distance in cells from the control body to the ends of the lines that guide a robot."""

SIDEWAYS = 1e-5
"""Smallest share of a push from the side that counts as a push along the heading."""


class WheeledRobot(Robot):
    """A robot with differential drive; see ``Robot``."""

    def _drive_joints(self) -> list[pymunk.Constraint]:
        """Create the joints to the control body, which moves and turns as commanded.

        A groove joint leaves the robot free to move along a line. The wheels push through a groove
        across the heading, and the tyres hold it with a groove along the heading.
        """
        reach = LINE * self._spec.cell_size
        across, along = (0.0, reach), (reach, 0.0)
        self._motor, self._tyres = (
            pymunk.GrooveJoint(self._control, self.body, (-x, -y), (x, y), (0, 0))
            for x, y in (across, along)
        )
        self._motor.max_bias = 0.0
        # A robot that the solver moves off its line, to correct an overlap, is back in one substep.
        self._tyres.error_bias = 0.0
        self._steering = pymunk.SimpleMotor(self.body, self._control, 0.0)
        self._turn_book = WorkBook((0.0,))
        self._leaves, self._is_to_face = 0, False
        self.phase = REST
        return [self._tyres, self._motor, self._steering]

    def begin(self, displacement: Cell, loaded: bool, acceleration: float) -> int:
        """Begin an action; see ``Robot.begin``."""
        self._take_line()
        self._is_to_face = displacement != (0, 0)
        return super().begin(displacement, loaded, acceleration)

    def set_off(self, turning: int) -> None:
        """Turn, wait until substep ``turning``, and then drive to the target.

        A robot whose action stays in its cell does none of this.
        """
        if self.action.goal != self.action.home:
            self._leaves = turning
            self.action.deadline += turning
            self.drive(0, self.action.target)

    def turn_to(self, direction: Cell) -> None:
        """Turn on the spot in an action that stays in its cell; see ``Robot.turn_to``."""
        self._leaves = 0
        self._turn_by(0, math.remainder(math.atan2(*direction) - self.body.angle, math.tau))

    def _rolls(self) -> bool:
        return self._rim_speed() > AT_REST or super()._rolls()

    def _rim_speed(self) -> float:
        """Return the speed in m/s at which the wheels turn the robot."""
        return abs(self.body.angular_velocity) * self._spec.wheel_arm

    def _substeps_to_brake(self, now: int) -> int:
        if self.phase == TURN:
            return max(self._braking, self._leaves - now)
        rim = self._rim_speed()
        if self.phase == BRAKE and rim > AT_REST:
            rate = max(
                self._spec.turning_acceleration(self._loaded), self._drag / self._turning_mass
            )
            return braking(rim, rate, self._spec.time_step)
        return super()._substeps_to_brake(now)

    def drive(
        self, now: int, waypoint: Position, share: float = 1.0, *, is_hard: bool = False
    ) -> None:
        """Drive to a position, or first turn on the spot if the robot would otherwise miss it.

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
            right, down = self._driving_part(pymunk.Vec2d(*offset(waypoint, self.position)))
            super().drive(
                now, (self.position[0] + right, self.position[1] + down), share, is_hard=is_hard
            )

    def has_arrived(self) -> bool:
        """Return whether the robot was at its target when its position was last read."""
        off = math.dist(self._position_on_line(), self.action.target)
        return off <= ARRIVED * self._spec.cell_size

    def mass_along(self, normal: Position) -> float:
        """Return the mass in kg with which the robot resists a push along ``normal``.

        Where the tyres hold, the robot can only move along its heading.
        """
        if self._slips:
            return self._mass
        return mass_on_line(self._mass, self._driving_part(pymunk.Vec2d(*normal)).length)

    def feel_floor(self) -> None:
        """Update drag and grip if the robot has entered another cell."""
        before = self._floor_cell
        super().feel_floor()
        if self._floor_cell != before:
            self._hold()

    def _turn_towards(self, displacement: Cell) -> int:
        """Return the substeps that the robot has to turn before it drives to its target."""
        angle = self._angle_to(self.action.target)
        if not angle:
            return 0
        profile = self._spec.turn_profile(angle, self._loaded)
        return profile.go + profile.brake

    def _angle_to(self, waypoint: Position) -> float:
        """Return the radians to turn before driving to a position, or 0 if no turn is needed."""
        right, down = offset(waypoint, self._position_on_line())
        angle = math.remainder(math.atan2(down, right) - self.body.angle, math.tau)
        if self.action.gave_up or not self._is_to_face:
            angle = math.remainder(angle, math.pi)
        misses = abs(math.sin(angle)) * math.hypot(right, down)
        is_ahead = abs(angle) <= math.pi / 2
        return 0.0 if is_ahead and misses <= ARRIVED * self._spec.cell_size / 2 else angle

    def _turn_by(self, now: int, angle: float) -> None:
        spec = self._spec
        profile = spec.turn_profile(angle, self._loaded)
        if self._conditions is not None:
            profile = profile.scaled(self._conditions.speed_factor())
        self._brake(now, 0)
        self._count_turn()
        self._control.angular_velocity = profile.velocity[0] / spec.wheel_arm
        wanted = min(self._turning_forces()[0], self._limit())
        self._steering.max_force = spec.wheel_arm * max(wanted - self._drag, 0.0)
        self.phase, self.until, self._braking = TURN, now + profile.go, profile.brake

    def _brake(self, now: int, substeps: int) -> None:
        if self.phase == TURN:
            self.action.work += spent(self._count_turn())
        self._control.angular_velocity = 0.0
        force = min(self._turning_forces()[1], self._limit()) + self._drag
        self._steering.max_force = self._spec.wheel_arm * force
        super()._brake(now, substeps)

    def _limit(self) -> float:
        """Return the largest force in N that the wheels can exert in this cell."""
        if self._conditions is None:
            return math.inf
        return self._conditions.force_limit(self._floor_cell, self._spec.motor_force, self._mass)

    def _turning_forces(self) -> tuple[float, float]:
        """Return the forces in N at the wheels with which turns speed up and brake."""
        rate = self._spec.turning_acceleration(self._loaded)
        return forces(self._turning_mass, rate, self._nominal_drag)

    def _count_turn(self) -> float:
        """Return the work in J of the wheels in a turn since it was last counted."""
        return self._turn_book.count(*self._turn_reading(), self._drag)

    def _turn_reading(self) -> tuple[tuple[float], float]:
        """Return the metres that a wheel has driven and the kinetic energy of the turn in J."""
        rim = self.body.angular_velocity * self._spec.wheel_arm
        turned = self.body.angle * self._spec.wheel_arm + self._lead * rim
        return (turned,), kinetic(self._turning_mass, rim, 0.0)

    def _count_phase(self) -> None:
        """Count the work of the turn, and the work of the drive unless the robot still turns."""
        if self.phase == TURN:
            return  # ``_brake`` counts the turn, because a hit may end it too
        if self.phase == BRAKE and self._spec.recuperation:
            self.action.work -= regained(self._spec, self._count_turn())
        if self._rim_speed() <= AT_REST:
            super()._count_phase()

    def _uncounted(self) -> float:
        """Return the work in J that the next count would add; see ``Robot._uncounted``."""
        if self.phase not in (TURN, BRAKE):
            return super()._uncounted()
        work = self._turn_book.until(*self._turn_reading(), self._drag)
        if self.phase == TURN:
            return spent(work)
        return super()._uncounted() - regained(self._spec, work)

    def _reading(self, velocity: Position, lead: float) -> tuple[Position, float]:
        """Return a reading for the book; see ``Robot._reading``.

        The part of the velocity to the side is not due to the wheels and is ignored.
        """
        return super()._reading(self._driving_part(pymunk.Vec2d(*velocity)), lead)

    def _driving_part(self, vector: pymunk.Vec2d) -> pymunk.Vec2d:
        """Return the part of a vector that is along the heading."""
        heading = pymunk.Vec2d.from_polar(1.0, self.body.angle)
        return heading * heading.dot(vector)

    def _load(self, loaded: bool, acceleration: float) -> None:
        """Set whether the robot carries an item, and its acceleration in m/s²."""
        self._turning_mass = self._spec.turning_mass(loaded)
        self._steering.max_force = 0.0
        super()._load(loaded, acceleration)
        self._hold()

    def _hold(self) -> None:
        """Make the tyres hold the robot on its line, as firmly as the floor in this cell allows.

        The drag of the floor resists motion to the side too, so it is subtracted.
        """
        force = math.inf
        if self._conditions is not None:
            force = max(self._conditions.grip_force(self._floor_cell, self._mass) - self._drag, 0.0)
        self._slips = force < math.inf
        self._tyres.max_force, self._tyres.max_bias = force, 0.0 if self._slips else math.inf
        self._take_line()

    def _take_line(self) -> None:
        """Move the line of the joints to the present position and heading of the robot."""
        self._control.position, self._control.angle = self.body.position, self.body.angle

    def _position_on_line(self) -> Position:
        """Return the position of the robot, projected onto its line where the tyres hold.

        The solver moves overlapping robots off their lines for one substep.
        """
        if self._slips:
            return self.position
        line = self._control.position
        return line + self._driving_part(self.body.position - line)


def mass_on_line(mass: float, share: float) -> float:
    """Return the mass in kg with which a robot that can only move along a line resists a push.

    ``share`` is the component of the push along the line, -1 to 1.
    """
    return mass / max(share * share, SIDEWAYS**2)
