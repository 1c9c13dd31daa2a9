"""One robot: a body with mass, the motor that drives it, and the drag of the floor.

*The motor* is a joint between the body and a control body, which has no shape and touches nothing.
The program writes a velocity to the control body. In each substep the joint pulls the robot towards
this velocity, with at most ``max_force`` newtons. A robot of mass ``m`` can therefore change its
speed by at most ``max_force * dt / m`` in a substep. The velocity and the largest force are all
that is ever commanded. The position and the velocity of the robot itself are only read, so whatever
the robot does is the result of forces.

*The floor* is a joint to the static body. It pulls the robot towards rest with at most the drag,
which is ``floor_drag * m * g`` newtons. To accelerate at ``a`` m/s² the motor pushes with
``m * a`` plus the drag. To brake at the same rate it needs only ``m * a`` minus the drag.

*A drive* has phases; see ``phases.py``. The robot is commanded a velocity while it goes and 0 while
it brakes. ``profile.py`` calculates the velocity and the duration of both, so that the robot stops
at its target. At rest the robot compares its position with the target, and drives again if it has
not arrived. After a hit with something that blocks it, the robot brakes and gives up. Its new
target is then the middle of the cell in which it began.

*Work* is counted from one phase to the next; see ``energy.py``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import product

import pymunk

from warehouse_core import Cell
from warehouse_core.motion.base import Contact, centre_of
from warehouse_physics.arena import Arena, Hit, Position
from warehouse_physics.disturbances import FloorConditions
from warehouse_physics.energy import WorkBook, kinetic, regained, spent
from warehouse_physics.phases import (
    AT_REST,
    BRAKE,
    DUE,
    GO,
    HELD,
    LATE,
    MET,
    NEVER,
    NEXT,
    OFF,
    REST,
    ROLLS,
    THERE,
)
from warehouse_physics.profile import braking, plan_profile
from warehouse_physics.spec import ARRIVED, RobotSpec
from warehouse_physics.stepping import read

BodyRow = tuple[float, ...]
"""A row of ``Outcome.path`` followed by a row of ``Outcome.readings``, 9 numbers in all."""

MAX_SECONDS = 180.0
"""Seconds after which the action of a robot ends, wherever it is."""


@dataclass(slots=True)
class ActionState:
    """The state of one action of a robot.

    Attributes:
        home: cell in which the action began.
        goal: cell to which the action leads; ``home`` if the robot stays.
        target: middle of ``goal``, or of ``home`` after the robot gave up, in metres.
        deadline: substep after which the robot makes no new attempt.
        gave_up: true if something was in the way.
        is_followed: true if another robot drives to ``home``.
        has_met: true if the robot touched another robot.
        last_hit: substep of the latest hit, or 0.
        rested: substep at which the robot came to rest.
        contacts: hits so far, as they are reported.
        work: work of the motor so far, in joules.
    """

    home: Cell
    goal: Cell
    target: Position
    deadline: float = math.inf
    gave_up: bool = False
    is_followed: bool = False
    has_met: bool = False
    last_hit: int = 0
    rested: int = 0
    contacts: list[Contact] = field(default_factory=list)
    work: float = 0.0


class Robot:
    """A robot in an arena, which begins at rest in a cell and faces east.

    Attributes:
        position: middle of the body when it was last read, in metres.
        velocity: velocity of the body then, in m/s.
        angle: heading of the body then, in radians.
        action: latest action.
        phase: current phase of the drive; see ``phases.py``.
        until: substep at which the phase ends, or ``NEVER``.
    """

    def __init__(
        self, arena: Arena, spec: RobotSpec, cell: Cell, floor: FloorConditions | None
    ) -> None:
        self._spec, self._conditions = spec, floor
        self._lead = spec.time_step / 2
        self.body = pymunk.Body(1.0, 1.0)  # _load sets its mass and moment
        self.body.position = centre = centre_of(cell, spec.cell_size)
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._floor = pymunk.PivotJoint(arena.space.static_body, self.body, (0, 0), (0, 0))
        self._floor.max_bias = 0.0
        # The motor comes after the floor, so that its impulse is the last in each solver round.
        arena.add_robot(self.body, self._control, self._floor, *self._drive_joints())
        self.action = ActionState(cell, cell, centre)
        self._heading = self._turn = 0.0
        self._aim: Position = (1.0, 0.0)
        self.look()
        self._book, self._braking = WorkBook(self.position), 0  # substeps to brake after GO
        self._floor_cell = cell
        self._load(False, spec.acceleration)
        self._brake(0, 0)
        self.phase, self.until = REST, NEVER

    def _drive_joints(self) -> list[pymunk.Constraint]:
        """Create the joints to the control body: the motor, and a joint that turns the body."""
        self._motor: pymunk.Constraint = pymunk.PivotJoint(self.body, self._control, (0, 0), (0, 0))
        self._motor.max_bias = 0.0
        # A disc can drive in any direction. Its heading follows the direction of its motion within
        # one substep, unless it turns on the spot, at the constant rate ``max_bias``.
        self._steering: pymunk.Constraint = pymunk.GearJoint(self.body, self._control, 0.0, 1.0)
        self._steering.error_bias = 0.0
        return [self._motor, self._steering]

    def look(self) -> None:
        """Read the position in metres, the velocity in m/s and the heading of the body."""
        x, y, right, down, self.angle = read(self.body)
        self.position, self.velocity = (x, y), (right, down)

    def row(self, seconds: float) -> BodyRow:
        """Return the row for what was last read, ``seconds`` after the action began."""
        (x, y), (right, down), phase, spec = self.position, self.velocity, self.phase, self._spec
        work = self.action.work
        if phase != BRAKE or spec.recuperation:
            work += self._uncounted()
        joules = work / spec.drivetrain_efficiency + spec.idle_power * seconds
        newtons, (ahead, aside) = 0.0, self._aim
        if phase in (GO, BRAKE):
            newtons = self._motor.impulse / spec.time_step
        if phase == BRAKE:
            speed = math.hypot(right, down)
            newtons = -newtons
            if speed > AT_REST:
                ahead, aside = right / speed, down / speed
        return (
            seconds, x, y, self.angle, right, down, newtons * ahead, newtons * aside,
            joules if joules > 0 else 0.0,
        )  # fmt: skip

    @property
    def cell(self) -> Cell:
        """The cell under the middle of the body when its position was last read."""
        x, y = self.position
        return math.floor(y / self._spec.cell_size), math.floor(x / self._spec.cell_size)

    def begin(self, displacement: Cell, loaded: bool, acceleration: float) -> int:
        """Begin an action and return the substeps that the robot has to turn on the spot first.

        The robot is to drive to the middle of the cell at ``displacement``, or back if something is
        in the way, and to accelerate at ``acceleration`` m/s². It sets off when ``set_off`` is
        called.
        """
        if loaded != self._loaded or acceleration != self._acceleration:
            self._load(loaded, acceleration)
        self.look()
        home = self.cell
        goal = home[0] + displacement[0], home[1] + displacement[1]
        deadline = math.inf if self._conditions is None else self._deadline(self._conditions)
        self.action = ActionState(home, goal, centre_of(goal, self._spec.cell_size), deadline)
        return self._turn_towards(displacement) if goal != home else 0

    def set_off(self, turning: int) -> None:
        """Turn on the spot for ``turning`` substeps and then drive to the target.

        A robot whose action stays in its cell does neither.
        """
        if self.action.goal == self.action.home:
            return
        if turning:
            self._turn_within(turning)
            self.action.deadline += turning
            self._brake(0, turning)
        else:
            self.drive(0, self.action.target)

    def turn_to(self, direction: Cell) -> None:
        """Turn on the spot in the shorter direction, in an action that stays in its cell.

        A robot that can drive in any direction without turning takes as long as for a free move.
        """
        spec = self._spec
        substeps = self._turn_towards(direction)
        substeps = substeps or math.ceil(spec.move_seconds(self._loaded) / spec.time_step)
        self._turn_within(substeps)
        self._brake(0, substeps)

    def next_phase(self, now: int) -> None:
        """Start the phase that is due at substep ``now``."""
        self.look()
        self._count_phase()
        following = NEXT[self.phase, self._event(now)]
        if following == BRAKE:
            self._brake(now, self._substeps_to_brake(now))
        elif following == REST:
            self.rest(now)
        elif following == HELD:
            self.phase, self.until = HELD, NEVER
        else:
            self.drive(now, self.waypoint())

    def _event(self, now: int) -> int:
        """Return the event that ends the present phase at substep ``now``; see ``phases.py``."""
        action = self.action
        if self.phase != BRAKE:
            return DUE
        if self._rolls():
            return ROLLS
        if now >= action.deadline:
            return LATE
        if self.has_arrived():
            return THERE
        return MET if action.has_met or (action.gave_up and action.is_followed) else OFF

    def _rolls(self) -> bool:
        return math.hypot(*self.velocity) > AT_REST

    def _substeps_to_brake(self, now: int) -> int:
        """Return how long to brake from substep ``now``, after a phase or since it still rolls."""
        if self.phase == GO:
            return self._braking
        return self._braking_from(math.hypot(*self.velocity))

    def drive(
        self, now: int, waypoint: Position, share: float = 1.0, *, is_hard: bool = False
    ) -> None:
        """Drive to a position in metres.

        The robot uses a ``share`` of its normal speed and acceleration. With ``is_hard`` it uses
        the full force of the motor instead.
        """
        acceleration = (
            self._spec.greatest_acceleration(self._loaded)
            if is_hard
            else self._acceleration * share
        )
        self._book.start(self.position)
        profile = plan_profile(self.position, waypoint, *self._spec.limits(acceleration, share))
        if self._conditions is not None:
            profile = profile.scaled(self._conditions.speed_factor())
        self._control.velocity = right, down = profile.velocity
        speed = math.hypot(right, down) or 1.0
        self._aim = right / speed, down / speed
        force, self._braking_force = forces(self._mass, acceleration, self._nominal_drag)
        self._push(force)
        self.phase, self.until, self._braking = GO, now + profile.go, profile.brake

    def restore_braking(self) -> None:
        """Brake with the normal force again, after a drive with the full force of the motor."""
        self._brake_normally()
        self._push(self._braking_force)

    def rest(self, now: int) -> None:
        """End the action at substep ``now``, at rest."""
        self.phase, self.until, self.action.rested = REST, NEVER, now

    def waypoint(self, *, longer_first: bool = False) -> Position:
        """Return the next position to drive to in order to reach the target, in metres.

        Normally this is the target. If the robot was pushed so far aside that the corner of a wall
        could be in its way, it makes two straight drives, each along one axis, and the shorter one
        comes first. The shorter drive leads back to the middle of the lane and no closer to a wall.
        A robot that was pushed even further may meet another wall on this drive. It gets around
        that wall if it makes the longer drive first.
        """
        (x, y), (to_x, to_y) = self.position, self.action.target
        half = self._spec.cell_size / 2
        aside = min(abs(x - to_x), abs(y - to_y))
        if aside <= half - self._spec.radius:
            return to_x, to_y
        for corner in product((to_x - half, to_x + half), (to_y - half, to_y + half)):
            before, after = offset(self.position, corner), offset((to_x, to_y), corner)
            if comes_closer(before, after, self._spec.radius):
                along_x = (abs(x - to_x) == aside) != longer_first
                return (to_x, y) if along_x else (x, to_y)
        return to_x, to_y

    def meet(self, now: int, hit: Hit, other: Robot | None) -> None:
        """Record a hit with a wall or another robot at substep ``now``, and react to it.

        The robot gives up if the hit is in its way.
        """
        if hit.impulse > 0:  # not if they slide along each other or already separate
            self.action.contacts.append(hit.contact(now * self._spec.time_step))
        self.action.has_met |= other is not None
        self.look()
        if self.phase == GO and self.action.last_hit < now:
            self._count_impact(hit)
        elif self.action.last_hit < now:
            self._count(hit.velocity, -self._lead)
            self._book.start(*self._reading(self.body.velocity, self._lead))
        self.action.last_hit = now
        if self._is_hindered_by(hit, None if other is None else other.action):
            self.give_up()
            self.halt(now)
        elif self.phase != GO:
            self.halt(now)

    def is_counting(self) -> bool:
        """Return whether the motor does or recovers work in the present phase."""
        return self.phase == GO or self._spec.recuperation > 0

    def count_push(self, before: pymunk.Vec2d) -> None:
        """Count the work of the motor in a substep in which the robot touches another one.

        ``before`` is its velocity at the start of the substep. Energy that the contact gives to the
        robot, or takes from it, is not work of its motor.
        """
        impulses: list[pymunk.Vec2d] = []
        self.body.each_arbiter(lambda arbiter: impulses.append(arbiter.total_impulse))
        velocity = self.body.velocity
        mean = self._driving_part(before + velocity) / 2
        self.look()
        self._count(velocity, self._lead, sum(each.dot(mean) for each in impulses))

    def give_up(self) -> None:
        """Make the middle of the cell in which the action began the target."""
        self.action.gave_up = True
        self.action.target = centre_of(self.action.home, self._spec.cell_size)

    def halt(self, now: int) -> None:
        """Begin to brake at substep ``now``, until the robot is at rest."""
        self._brake(now, self._braking_from(self.body.velocity.length))

    def is_blocked(self) -> bool:
        """Return whether something has stopped the robot on its drive to another cell."""
        action, cell = self.action, self.cell
        return cell != action.goal != action.home and (action.gave_up or bool(action.contacts))

    def is_moving(self) -> bool:
        """Return whether the body moves, even if only because another robot pushes it."""
        return bool(self.body.velocity.length > AT_REST)

    def has_arrived(self) -> bool:
        """Return whether the robot was at its target when its position was last read."""
        return math.dist(self.position, self.action.target) <= ARRIVED * self._spec.cell_size

    def mass_along(self, normal: Position) -> float:
        """Return the mass in kg with which the robot resists a push along ``normal``."""
        return self._mass

    def feel_floor(self) -> None:
        """Update the drag and the largest force if the robot has entered another cell."""
        self.look()
        cell = self.cell
        if self._conditions is not None and cell != self._floor_cell:
            self._count(self.velocity, self._lead)
            self._floor_cell = cell
            self._drag = self._nominal_drag * self._conditions.drag_factor(cell)
            self._floor.max_force = self._drag
            self._push(self._force)

    def _is_hindered_by(self, hit: Hit, other: ActionState | None) -> bool:
        """Return whether a hit with a wall, or with a robot in the action ``other``, is in the way.

        A wall is in the way if the contact is within the lane, lies before the middle of the goal,
        and pushes against the direction of the move more than to its side. Another robot is in the
        way if it drives to the same goal or stays there, if it comes head-on, or if it has given up
        and returns to the goal of this robot. Any other robot was only pushed there and will not
        stay.
        """
        home, goal = self.action.home, self.action.goal
        if self.action.gave_up or goal == home:
            return False
        if other is not None:
            is_on_the_way = other.gave_up or other.goal == home
            return other.goal == goal or (other.home == goal and is_on_the_way)
        down, right = goal[0] - home[0], goal[1] - home[1]
        along = hit.push[0] * right + hit.push[1] * down
        across = hit.push[0] * down - hit.push[1] * right
        x, y = offset(hit.point, self.action.target)
        is_in_lane = abs(x * down - y * right) < self._spec.cell_size / 2
        return is_in_lane and x * right + y * down < 0 and -along > abs(across)

    def _brake(self, now: int, substeps: int) -> None:
        self._control.velocity = (0.0, 0.0)
        self._push(self._braking_force)
        self.phase, self.until = BRAKE, now + substeps

    def _brake_normally(self) -> None:
        """Set the force with which the motor brakes to the normal one."""
        self._braking_force = forces(self._mass, self._acceleration, self._nominal_drag)[1]

    def _braking_from(self, speed: float) -> int:
        deceleration = max(self._acceleration, self._spec.floor_deceleration)
        return braking(speed, deceleration, self._spec.time_step)

    def _turn_towards(self, displacement: Cell) -> int:
        """Turn the heading in the shorter direction, and return the substeps to turn on the spot.

        These are 0 if the robot turns while it drives. Driving back after a hit does not turn it.
        """
        self._turn = math.remainder(math.atan2(*displacement) - self._heading, math.tau)
        if self._turn:
            self._heading += self._turn
            self._control.angle = self._heading
            self._steering.max_bias = math.inf
        return self._spec.turn_substeps(round(abs(self._turn) / (math.pi / 2)))

    def _turn_within(self, substeps: int) -> None:
        """Turn on the spot at a constant rate, which takes a number of substeps."""
        self._steering.max_bias = abs(self._turn) / (substeps * self._spec.time_step)

    def _push(self, force: float) -> None:
        """Let the motor push with ``force`` N, or less where motor or floor limit it."""
        self._force = force
        if self._conditions is not None:
            limit = self._conditions.force_limit(
                self._floor_cell, self._spec.motor_force, self._mass
            )
            force = min(force, limit)
        self._motor.max_force = force

    def _count_phase(self) -> None:
        """Count the work of a phase that is over."""
        self._count(self.velocity, self._lead)

    def _count(self, velocity: Position, lead: float, received: float = 0.0) -> None:
        """Count the work of the motor up to a reading; see ``_reading``.

        Energy in J that the robot has ``received`` from others is not work of its motor. A motor
        that brakes may recover energy.
        """
        if not self.is_counting():
            return
        work = self._book.count(*self._reading(velocity, lead), self._drag) - received
        if self.phase == GO:
            self.action.work += spent(work)
        else:
            self.action.work -= regained(self._spec, work)

    def _uncounted(self) -> float:
        """Return the work in J that the next count would add."""
        if self.phase not in (GO, BRAKE):
            return 0.0
        work = self._book.until(*self._reading(self.velocity, self._lead), self._drag)
        return spent(work) if self.phase == GO else -regained(self._spec, work)

    def _reading(self, velocity: Position, lead: float) -> tuple[Position, float]:
        """Return a reading for the book: a position in metres and the kinetic energy in J.

        The position belongs to a point ``lead`` seconds ahead of the body; see ``energy.py``.
        """
        (x, y), (right, down) = self.position, velocity
        return (x + lead * right, y + lead * down), kinetic(self._mass, right, down)

    def _count_impact(self, hit: Hit) -> None:
        """Add the work up to a hit in this substep, and the work of the motor during the hit.

        Before the hit, work is counted up to the middle of the substep. During the hit the motor
        pushes towards the commanded velocity, or against the hit if the body already has that
        velocity. The work of this impulse is the impulse times the mean of the velocities before
        and after.
        """
        self._count(hit.velocity, -self._lead)
        after = self.body.velocity
        aim = self._driving_part(self._control.velocity - after)
        if aim.length < AT_REST:
            aim = self._driving_part(-pymunk.Vec2d(*hit.push))
        forward = aim.normalized().dot(after + hit.velocity) / 2
        self.action.work += spent(self._motor.impulse * forward)
        self._book.start(*self._reading(after, self._lead))

    def _driving_part(self, vector: pymunk.Vec2d) -> pymunk.Vec2d:
        """Return the part of a vector in whose direction the motor can push, here all of it."""
        return vector

    def _deadline(self, floor: FloorConditions) -> float:
        """Return the substep after which the robot makes no new attempt."""
        target = self._spec.cell_size, 0.0
        profile = plan_profile((0.0, 0.0), target, *self._spec.limits(self._acceleration))
        return floor.patience * (profile.go + profile.brake)

    def _load(self, loaded: bool, acceleration: float) -> None:
        """Set whether the robot carries an item, and its acceleration in m/s²."""
        self._loaded, self._acceleration = loaded, acceleration
        self._drag = self._nominal_drag = self._spec.drag_force(loaded)
        self.body.mass = self._mass = self._spec.total_mass(loaded)
        self.body.moment = pymunk.moment_for_circle(self._mass, 0.0, self._spec.radius)
        self._brake_normally()
        if self._conditions is not None:
            self._drag *= self._conditions.drag_factor(self._floor_cell)
        self._floor.max_force = self._drag


def forces(mass: float, rate: float, drag: float) -> tuple[float, float]:
    """Return the forces in N with which a motor speeds up and brakes a mass.

    The mass is in kg, the rate in m/s² and the drag in N. The floor helps to brake. The motor does
    the rest, and nothing if the floor alone brakes harder.
    """
    return mass * rate + drag, max(mass * rate - drag, 0.0)


def offset(position: Position, other: Position) -> Position:
    """Return the vector to ``position`` from ``other``."""
    return position[0] - other[0], position[1] - other[1]


def comes_closer(before: Position, after: Position, reach: float) -> bool:
    """Return whether a straight path comes closer to the origin than ``reach``.

    A path that starts closer but leads away does not count.
    """
    path = offset(after, before)
    towards = -(before[0] * path[0] + before[1] * path[1])
    if towards <= 0:
        return False
    done = min(1.0, towards / (path[0] ** 2 + path[1] ** 2))
    return math.hypot(before[0] + done * path[0], before[1] + done * path[1]) < reach
