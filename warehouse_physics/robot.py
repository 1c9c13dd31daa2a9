"""One robot: a body with mass, the motor that drives it, and the drag of the floor.

The motor is a joint of finite force to a control body whose velocity is written; nothing else is
ever commanded. Position and velocity of the robot itself are only read.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from itertools import product

import pymunk

from warehouse_core import Cell
from warehouse_core.motion.base import Contact, centre_of
from warehouse_physics.arena import Arena, Hit, Position
from warehouse_physics.disturbances import FloorConditions
from warehouse_physics.energy import kinetic, regained, spent
from warehouse_physics.profile import braking, plan_profile
from warehouse_physics.spec import ARRIVED, RobotSpec

TURN_RATE, TURN_ACCELERATION = math.pi, 60.0
"""Limits of the heading in rad/s and rad/s² for a free move of ``TURN_SECONDS``; a robot that moves
``k`` times as fast turns ``k`` times as fast. The heading of a disc does not change where it goes.
"""

TURN_SECONDS = 2.0
"""Seconds of a free move of the default robot over a cell."""

AT_REST = 1e-6
"""Speed in m/s below which a robot stands still; less than the solver may leave after a hit."""

REST, GO, BRAKE, HELD = range(4)
"""Phases of a drive; a robot that is held waits for others at rest, see ``giving_way.py``."""

NEVER = sys.maxsize
"""The substep at which a robot at rest has something to do."""

MAX_SUBSTEPS = 10_000
"""Substeps after which an action of one robot ends, wherever it is."""


@dataclass(slots=True)
class ActionState:
    """The state of one action.

    Attributes:
        home: cell in which the action began.
        target: middle of ``goal``, or of ``home`` after the robot gave up, in metres.
        deadline: substep after which no new attempt is made.
        gave_up: true if something was in the way.
        is_followed: true if another robot drives to ``home``.
        has_met: true if the robot touched another one.
        last_hit: substep of the last hit, or 0.
        rested: substep at which the robot came to rest.
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
    """A robot in an arena, at first at rest in a cell and heading east.

    Attributes:
        position: middle of the body at the last look, in metres.
        action: action that was begun last.
        phase: present phase of the drive: ``REST``, ``GO``, ``BRAKE`` or ``HELD``.
        until: substep at which the phase ends, or ``NEVER``.
    """

    def __init__(
        self, arena: Arena, spec: RobotSpec, cell: Cell, floor: FloorConditions | None
    ) -> None:
        self._spec, self._uneven = spec, floor
        self._lead = spec.time_step / 2
        self.body = pymunk.Body(1.0, 1.0)  # the load sets its mass and moment
        self.body.position = centre = centre_of(cell, spec.cell_size)
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._floor = pymunk.PivotJoint(arena.space.static_body, self.body, (0, 0), (0, 0))
        self._floor.max_bias = 0.0
        # The motor comes after the floor, so that its impulse is the last in each solver round.
        arena.add_robot(self.body, self._control, self._floor, *self._drive_joints())
        self.action = ActionState(cell, cell, centre)
        self._heading = self._turn = 0.0
        self.look()
        # The present profile: where work was last counted, the kinetic energy there, and the
        # substeps to brake at its end.
        self._start, self._energy, self._braking = self.position, 0.0, 0
        self._on = cell
        self._load(False, spec.acceleration)
        self._brake(0, 0)
        self.phase, self.until = REST, NEVER

    def _drive_joints(self) -> list[pymunk.Constraint]:
        """Make the joints to the control body: the motor, and the one that turns the body."""
        spec = self._spec
        self._motor: pymunk.Constraint = pymunk.PivotJoint(self.body, self._control, (0, 0), (0, 0))
        self._motor.max_bias = 0.0
        self._steering: pymunk.Constraint = pymunk.GearJoint(self.body, self._control, 0.0, 1.0)
        quickness = TURN_SECONDS / spec.move_seconds(loaded=False)
        self._steering.max_bias = TURN_RATE * quickness
        self._steering.error_bias **= quickness  # the error that is left after a second
        self._turn_acceleration = TURN_ACCELERATION * quickness**2
        if spec.turn_seconds:  # at a constant rate, which is reached in a substep
            self._steering.error_bias = 0.0
            self._turn_acceleration = math.pi / spec.turn_seconds / spec.time_step
        return [self._motor, self._steering]

    def look(self) -> None:
        """Read where the middle of the body is, in metres."""
        x, y = self.body.position
        self.position = x, y

    @property
    def cell(self) -> Cell:
        """The cell that the middle of the body was over at the last look."""
        x, y = self.position
        return math.floor(y / self._spec.cell_size), math.floor(x / self._spec.cell_size)

    def begin(self, displacement: Cell, loaded: bool, pace: float) -> int:
        """Begin an action: drive to the middle of a cell, or back if something is in the way.

        It drives with the acceleration ``pace`` in m/s². Return the substeps that it has to turn
        on the spot before; see ``set_off``.
        """
        if loaded != self._loaded or pace != self._pace:
            self._load(loaded, pace)
        self.look()
        home = self.cell
        goal = home[0] + displacement[0], home[1] + displacement[1]
        deadline = math.inf if self._uneven is None else self._deadline(self._uneven)
        self.action = ActionState(home, goal, centre_of(goal, self._spec.cell_size), deadline)
        return self._turn_towards(displacement) if goal != home else 0

    def set_off(self, turning: int) -> None:
        """Drive off after so many substeps, in which it turns on the spot; or stay."""
        if self.action.goal == self.action.home:
            return
        if turning:
            self._steering.max_bias = abs(self._turn) / (turning * self._spec.time_step)
            self.action.deadline += turning
            self._brake(0, turning)
        else:
            self.drive(0, self.action.target)

    def turn_to(self, direction: Cell) -> None:
        """Turn on the spot, the shorter way round, in an action that stays in its cell.

        A robot that need not turn before it drives takes as long for it as for a free move.
        """
        spec = self._spec
        substeps = self._turn_towards(direction)
        if substeps:
            self._steering.max_bias = abs(self._turn) / (substeps * spec.time_step)
        self._brake(0, substeps or math.ceil(spec.move_seconds(self._loaded) / spec.time_step))

    def next_phase(self, now: int) -> None:
        """Start the phase that is due at substep ``now``."""
        self.look()
        if self.phase == GO:
            self._count_work(self.body.velocity, self._lead)
            self._brake(now, self._braking)
            return
        self._count_braking(self.body.velocity, self._lead)
        action, speed = self.action, math.hypot(*self.body.velocity)
        if speed > AT_REST:
            self._brake(now, self._braking_from(speed))
        elif now >= action.deadline or self.has_arrived():
            self.rest(now)
        elif action.has_met or (action.gave_up and action.is_followed):
            self.phase, self.until = HELD, NEVER
        else:
            self.drive(now, self.waypoint())

    def drive(
        self, now: int, waypoint: Position, share: float = 1.0, *, is_hard: bool = False
    ) -> None:
        """Drive to a position.

        The speed and acceleration are a share of the usual ones; or the drive is a hard one, with
        all the force of the motor.
        """
        pace = self._spec.greatest_acceleration(self._loaded) if is_hard else self._pace * share
        self._start, self._energy = self.position, 0.0
        profile = plan_profile(self._start, waypoint, *self._spec.limits(pace, share))
        if self._uneven is not None:
            profile = profile.scaled(self._uneven.speed_factor())
        self._control.velocity = profile.velocity
        # The floor brakes too; the motor does the rest, so that the pace is the same both ways
        # where the floor alone does not brake harder.
        self._brake_at(pace)
        self._push(self._mass * pace + self._nominal_drag)
        self.phase, self.until, self._braking = GO, now + profile.go, profile.brake

    def brake_as_usual(self) -> None:
        """Brake with the usual force at rest, also after a hard drive."""
        self._brake_at(self._pace)
        self._push(self._braking_force)

    def rest(self, now: int) -> None:
        """End the action at substep ``now``, at rest."""
        self.phase, self.until, self.action.rested = REST, NEVER, now

    def waypoint(self, *, longer_first: bool = False) -> Position:
        """Return the next position to drive to on the way to the target.

        That is the target, unless a wall beside its cell could be in the way of a robot that was
        pushed aside. Then it first drives the shorter way along one axis: it is beside its lane,
        further from the target than from the middle of the lane, and on the way to that middle it
        comes closer to no wall. A robot that was pushed further may meet another wall there, which
        it gets around if it drives the longer way first.
        """
        (x, y), (to_x, to_y) = self.position, self.action.target
        half = self._spec.cell_size / 2
        aside = min(abs(x - to_x), abs(y - to_y))
        if aside <= half - self._spec.radius:
            return to_x, to_y
        for corner in product((to_x - half, to_x + half), (to_y - half, to_y + half)):
            before, after = apart(self.position, corner), apart((to_x, to_y), corner)
            if comes_closer(before, after, self._spec.radius):
                along_x = (abs(x - to_x) == aside) != longer_first
                return (to_x, y) if along_x else (x, to_y)
        return to_x, to_y

    def meet(self, now: int, hit: Hit, other: Robot | None) -> None:
        """Record a hit with a wall or another robot at substep ``now``; give up if hindered."""
        if hit.impulse > 0:  # not if they touch side on and already part
            self.action.contacts.append(hit.contact(now * self._spec.time_step))
        self.action.has_met |= other is not None
        self.look()
        if self.phase == GO and self.action.last_hit < now:
            self._count_impact(hit)
        elif self.action.last_hit < now:
            self._count_braking(hit.velocity, -self._lead)
            self._count_from(self.body.velocity, self._lead)
        self.action.last_hit = now
        if self._is_hindered_by(hit, None if other is None else other.action):
            self.give_up()
            self.halt(now)
        elif self.phase != GO:
            self.halt(now)

    def count_push(self, before: pymunk.Vec2d) -> None:
        """Count the work in a substep, at first at the velocity ``before``, in a touch.

        What the touch adds to the energy of the robot, or takes from it, is no work of its motor.
        """
        impulses: list[pymunk.Vec2d] = []
        self.body.each_arbiter(lambda arbiter: impulses.append(arbiter.total_impulse))
        velocity = self.body.velocity
        mean = self._driven(before + velocity) / 2
        self.look()
        work = self._worked(velocity, self._lead) - sum(each.dot(mean) for each in impulses)
        if self.phase == GO:
            self.action.work += spent(work)
        elif self._spec.recuperation:
            self.action.work -= regained(self._spec, work)

    def give_up(self) -> None:
        """Make the cell in which the action began the target."""
        self.action.gave_up = True
        self.action.target = centre_of(self.action.home, self._spec.cell_size)

    def halt(self, now: int) -> None:
        """Brake at substep ``now`` until it stands still."""
        self._brake(now, self._braking_from(self.body.velocity.length))

    def is_blocked(self) -> bool:
        """Return whether something stopped it on its way to another cell, at the last look."""
        action, cell = self.action, self.cell
        return cell != action.goal != action.home and (action.gave_up or bool(action.contacts))

    def is_moving(self) -> bool:
        """Return whether the body moves, also if another robot pushes it."""
        return bool(self.body.velocity.length > AT_REST)

    def has_arrived(self) -> bool:
        """Return whether it was at its target at the last look."""
        return math.dist(self.position, self.action.target) <= ARRIVED * self._spec.cell_size

    def mass_along(self, normal: Position) -> float:
        """Return the mass in kg with which the robot resists a push along ``normal``."""
        return self._mass

    def feel_floor(self) -> None:
        """Update drag and grip where the floor differs from cell to cell."""
        self.look()
        cell = self.cell
        if self._uneven is not None and cell != self._on:
            count = self._count_work if self.phase == GO else self._count_braking
            count(self.body.velocity, self._lead)
            self._on = cell
            self._drag = self._nominal_drag * self._uneven.drag_factor(cell)
            self._floor.max_force = self._drag
            self._push(self._force)

    def _is_hindered_by(self, hit: Hit, other: ActionState | None) -> bool:
        """Return whether a hit is in the way, with a wall or a robot in an action of its own.

        A wall is, if it reaches into the lane on this side of the goal and pushes against the way
        rather than across it. Another robot is, if it drives to the same cell or stays there, meets
        this one head-on, or has to go back to where this one drives. Any other robot was pushed
        there, and does not stay.
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
        x, y = apart(hit.point, self.action.target)
        is_in_lane = abs(x * down - y * right) < self._spec.cell_size / 2
        return is_in_lane and x * right + y * down < 0 and -along > abs(across)

    def _brake(self, now: int, substeps: int) -> None:
        self._control.velocity = (0.0, 0.0)
        self._push(self._braking_force)
        self.phase, self.until = BRAKE, now + substeps

    def _brake_at(self, pace: float) -> None:
        """Let the motor brake at ``pace`` m/s², or less if the floor alone brakes harder."""
        self._braking_force = max(self._mass * pace - self._nominal_drag, 0.0)

    def _braking_from(self, speed: float) -> int:
        deceleration = max(self._pace, self._spec.floor_deceleration)
        return braking(speed, deceleration, self._spec.time_step)

    def _turn_towards(self, displacement: Cell) -> int:
        """Turn the heading the shorter way round; the way back does not turn it.

        Return the substeps that this takes on the spot, or 0 if the robot turns while it drives.
        """
        self._turn = math.remainder(math.atan2(*displacement) - self._heading, math.tau)
        if self._turn:
            self._heading += self._turn
            self._control.angle = self._heading
        return self._spec.turn_substeps(round(abs(self._turn) / (math.pi / 2)))

    def _push(self, force: float) -> None:
        """Let the motor push with up to ``force`` N, or less if motor or floor limit it."""
        self._force = force
        if self._uneven is not None:
            limit = self._uneven.force_limit(self._on, self._spec.motor_force, self._mass)
            force = min(force, limit)
        self._motor.max_force = force

    def _count_work(self, velocity: pymunk.Vec2d, lead: float) -> None:
        """Add the work of the motor, which drives, since the last count; see ``_worked``."""
        self.action.work += spent(self._worked(velocity, lead))

    def _count_braking(self, velocity: pymunk.Vec2d, lead: float) -> None:
        """Take off what the motor, which brakes, got back since the last count; see ``_worked``."""
        if self._spec.recuperation:
            self.action.work -= regained(self._spec, self._worked(velocity, lead))

    def _worked(self, velocity: pymunk.Vec2d, lead: float) -> float:
        """Return the work of the motor since the last count: kinetic energy gained, plus drag.

        Positions move before velocities change. So the way, over which drag is counted, is that
        of a point ``lead`` seconds ahead of the middle, at ``velocity``.
        """
        start, energy = self._start, self._energy
        self._count_from(velocity, lead)
        drag = self._drag * math.dist(start, self._start)
        return self._energy - energy + drag

    def _count_from(self, velocity: pymunk.Vec2d, lead: float) -> None:
        """Begin to count work at this position and ``velocity``."""
        (x, y), (right, down) = self.position, velocity
        self._start = x + lead * right, y + lead * down
        self._energy = kinetic(self._mass, right, down)

    def _count_impact(self, hit: Hit) -> None:
        """Add the work up to a hit in this substep, and of the push of the motor in the hit.

        The motor pushes towards the commanded velocity, or against the hit if it holds that, at
        the mean of the velocities before and after. Its work before that is up to half a substep
        ago.
        """
        self._count_work(hit.velocity, -self._lead)
        after = self.body.velocity
        aim = self._driven(self._control.velocity - after)
        if aim.length < AT_REST:
            aim = self._driven(-pymunk.Vec2d(*hit.push))
        forward = aim.normalized().dot(after + hit.velocity) / 2
        self.action.work += spent(self._motor.impulse * forward)
        self._count_from(after, self._lead)

    def _driven(self, vector: pymunk.Vec2d) -> pymunk.Vec2d:
        """Return the part of a vector in whose direction the motor can push: all of it."""
        return vector

    def _deadline(self, floor: FloorConditions) -> float:
        """Return the substep after which no new attempt is made."""
        way = self._spec.cell_size, 0.0
        profile = plan_profile((0.0, 0.0), way, *self._spec.limits(self._pace))
        return floor.patience * (profile.go + profile.brake)

    def _load(self, loaded: bool, pace: float) -> None:
        """Set the load, and the acceleration in m/s² to drive with."""
        self._loaded, self._pace = loaded, pace
        self._drag = self._nominal_drag = self._spec.drag_force(loaded)
        self.body.mass = self._mass = self._spec.total_mass(loaded)
        self.body.moment = pymunk.moment_for_circle(self._mass, 0.0, self._spec.radius)
        self._brake_at(pace)
        if self._uneven is not None:
            self._drag *= self._uneven.drag_factor(self._on)
        self._floor.max_force = self._drag
        self._steering.max_force = self.body.moment * self._turn_acceleration


def apart(position: Position, other: Position) -> Position:
    """Return the way to a position from another."""
    return position[0] - other[0], position[1] - other[1]


def comes_closer(before: Position, after: Position, reach: float) -> bool:
    """Return whether a straight way comes closer to the origin than ``reach``.

    One that starts closer may lead away from there.
    """
    way = apart(after, before)
    towards = -(before[0] * way[0] + before[1] * way[1])
    if towards <= 0:
        return False
    done = min(1.0, towards / (way[0] ** 2 + way[1] ** 2))
    return math.hypot(before[0] + done * way[0], before[1] + done * way[1]) < reach
