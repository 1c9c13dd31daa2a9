"""One robot: a body with mass, the motor that drives it, and the drag of the floor.

The motor is a joint of finite force to a control body whose velocity is written; nothing else is
ever commanded. Position and velocity of the robot itself are only read.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from typing import NamedTuple

import pymunk

from warehouse_core import Cell
from warehouse_core.motion.base import Contact, centre_of
from warehouse_physics.disturbances import FloorConditions
from warehouse_physics.profile import braking, plan_profile
from warehouse_physics.robot_spec import ARRIVED, RobotSpec
from warehouse_physics.stepping import arbiters_of

Position = tuple[float, float]

ROBOT, WALL = 1, 2
"""Collision types."""

MAX_TURN_RATE, MAX_TURN_ACCELERATION = math.pi, 60.0
"""Of the heading, in rad/s and rad/s²; the heading of a disc does not change where it goes."""

AT_REST = 1e-9
"""Speed in m/s below which a robot stands still."""

AGAINST = 0.3
"""Share of a push that must be against the direction of travel to block a robot."""

PAUSE = 0.5
"""Seconds that a robot on its way back waits for one that follows it and must go back first."""

MAX_WAITS = 20

MAX_RETURNS = 8
"""Profiles of a way back after which a stuck robot tries the other direction every other time."""

FITTING = 0.9
"""Share of the free width beside a robot in its lane that it may use."""

REST, GO, BRAKE = range(3)
"""What a drive is doing."""

NEVER = sys.maxsize
"""The substep at which a robot at rest has something to do."""

MAX_SUBSTEPS = 10_000
"""Substeps after which an action ends, wherever the robots are."""


class Touch(NamedTuple):
    """A hit as one robot feels it: with another robot, or with a wall if ``other`` is ``None``.

    ``push`` is the direction of the push on it, of length 1, and ``velocity`` its velocity right
    before the hit in m/s.
    """

    other: Robot | None
    push: Position
    velocity: Position


@dataclass(slots=True)
class Action:
    """The state of one action.

    Attributes:
        home: cell in which it began.
        goal: cell to drive to.
        target: middle of ``goal``, or of ``home`` after the robot gave up, in metres.
        deadline: substep after which no new attempt is made.
        gave_up: something was in the way.
        waits: times that the robot gave way on its way back.
        returns: profiles of the way back.
        contacts: hits so far.
        work: of the motor so far, in joules.
    """

    home: Cell
    goal: Cell
    target: Position
    deadline: float = math.inf
    gave_up: bool = False
    waits: int = 0
    returns: int = 0
    contacts: list[Contact] = field(default_factory=list)
    work: float = 0.0


class Robot:
    """A robot in a space.

    Args:
        space: that its body and joints are added to.
        spec: what it is made of.
        cell: where it starts, at rest and heading east.
        robots: those of the arena by body, in order; the robot adds itself.
        floor: conditions that disturb it, or ``None``.

    Attributes:
        number: of the robot in its arena.
        action: the last one begun.
    """

    def __init__(
        self,
        space: pymunk.Space,
        spec: RobotSpec,
        cell: Cell,
        robots: dict[pymunk.Body, Robot],
        floor: FloorConditions | None = None,
    ) -> None:
        self._spec, self._uneven = spec, floor
        self.body = pymunk.Body(1.0, 1.0)  # the load sets its mass and moment
        self.number, self._robots = len(robots), robots
        robots[self.body] = self
        self.body.position = centre = centre_of(cell, spec.cell_size)
        shape = pymunk.Circle(self.body, spec.radius)
        shape.collision_type = ROBOT
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._floor = pymunk.PivotJoint(space.static_body, self.body, (0, 0), (0, 0))
        self._motor = pymunk.PivotJoint(self.body, self._control, (0, 0), (0, 0))
        self._steering = pymunk.GearJoint(self.body, self._control, 0.0, 1.0)
        self._floor.max_bias = self._motor.max_bias = 0.0
        self._steering.max_bias = MAX_TURN_RATE
        # The motor comes after the floor, so that its impulse is the last in each solver round.
        space.add(self.body, shape, self._control, self._floor, self._motor, self._steering)
        self.action = Action(cell, cell, centre)
        self._heading = 0.0
        self.look()
        # Of the present profile: where work was last counted, the kinetic energy there, whether
        # it leads back, and for how many substeps to brake at its end.
        self._start, self._energy = self.position, 0.0
        self._returning, self._braking = False, 0
        self._on = cell
        self._load(False, spec.acceleration)
        self._brake(0, 0)
        self.phase, self.until = REST, NEVER

    def look(self) -> None:
        """Read where the middle of the body is, in metres."""
        x, y = self.body.position
        self.position = x, y

    @property
    def cell(self) -> Cell:
        """The cell that the middle of the body was over at the last look."""
        x, y = self.position
        return math.floor(y / self._spec.cell_size), math.floor(x / self._spec.cell_size)

    def begin(self, displacement: Cell, loaded: bool, pace: float) -> None:
        """Begin an action: drive to the middle of a cell, or back if something is in the way.

        Args:
            displacement: ``(0, 0)``, or one cell in one direction.
            loaded: whether it carries an item.
            pace: acceleration in m/s² to drive with.
        """
        if loaded != self._loaded or pace != self._pace:
            self._load(loaded, pace)
        self.look()
        home = self.cell
        goal = home[0] + displacement[0], home[1] + displacement[1]
        deadline = math.inf if self._uneven is None else self._deadline(self._uneven)
        self.action = Action(home, goal, centre_of(goal, self._spec.cell_size), deadline)
        if goal != home:
            self._turn_towards(displacement)
            self._go(0)

    def next_phase(self, now: int) -> None:
        """Start the phase that is due at substep ``now``."""
        self.look()
        if self.phase == GO:
            self._count_work(self.body.velocity)
            self._brake(now, self._braking)
            return
        speed = math.hypot(*self.body.velocity)
        if speed > AT_REST:
            self._brake(now, self._braking_from(speed))
        elif now >= self.action.deadline or self._has_arrived():
            self.phase, self.until = REST, NEVER
        elif self.action.gave_up and self._must_wait(now):
            self._give_way(now)
        else:
            self._go(now)

    def meet(self, now: int, touch: Touch, contact: Contact) -> None:
        """Record a hit at substep ``now``, and give up if it is in the way."""
        self.action.contacts.append(contact)
        self.look()
        if self.phase == GO:
            self._count_work(touch.velocity)
        if self._is_hindered_by(touch):
            self.give_up(now)
        elif self.phase != GO:
            self._brake(now, self._braking_from(self.body.velocity.length))
        elif self._returning and touch.other is not None and touch.other.follows(self):
            self._give_way(now)

    def give_up(self, now: int) -> None:
        """Brake at substep ``now``, then drive back to where the action began."""
        self.action.gave_up = True
        self.action.target = centre_of(self.action.home, self._spec.cell_size)
        self._brake(now, self._braking_from(self.body.velocity.length))

    def feel_floor(self) -> None:
        """Update drag and grip where the floor differs from cell to cell."""
        self.look()
        cell = self.cell
        if self._uneven is not None and cell != self._on:
            if self.phase == GO:
                self._count_work(self.body.velocity)
            self._on = cell
            self._drag = self._nominal_drag * self._uneven.drag_factor(cell)
            self._floor.max_force = self._drag
            self._push(self._force)

    def follows(self, other: Robot) -> bool:
        """Return whether this robot drives to the cell that ``other`` left, not head-on."""
        mine, theirs = self.action, other.action
        return mine.goal == theirs.home != mine.home != theirs.goal

    def _touching(self) -> list[Robot]:
        """Return the robots that touch this one, in order."""
        bodies = {body for arbiter in arbiters_of(self.body) for body in arbiter.bodies}
        bodies.discard(self.body)
        return [robot for body, robot in self._robots.items() if body in bodies]

    def _must_wait(self, now: int) -> bool:
        """Make touching robots that follow this one give up, and let them go back first.

        They may have touched it before it had to go back. Robots in a ring would wait for each
        other forever, hence the limit.
        """
        followers = [robot for robot in self._touching() if robot.follows(self)]
        for robot in followers:
            if not robot.action.gave_up:
                robot.give_up(now)
        self.action.waits += 1
        return bool(followers) and self.action.waits <= MAX_WAITS

    def _give_way(self, now: int) -> None:
        """Stand without brakes for a while, so that another robot can push past."""
        self._brake(now, round(PAUSE / self._spec.time_step))
        self._push(0.0)

    def _is_hindered_by(self, touch: Touch) -> bool:
        """Return whether a hit is against the way, or with a robot that returns to its cell."""
        home, goal = self.action.home, self.action.goal
        if self.action.gave_up or goal == home:
            return False
        other = touch.other
        if other is not None and other.action.gave_up:
            if self.follows(other):
                return True
            # Pushed aside by a third robot, it returns to where it is not in the way.
            if goal not in (other.action.home, other.action.goal):
                return False
        down, right = goal[0] - home[0], goal[1] - home[1]
        return touch.push[0] * right + touch.push[1] * down < -AGAINST

    def _go(self, now: int) -> None:
        spec, action = self._spec, self.action
        self._start, self._energy = self.position, 0.0
        self._returning = action.gave_up or action.goal == action.home
        limits = spec.top_speed, self._pace, spec.time_step
        profile = plan_profile(self._start, self._waypoint(), *limits)
        if self._uneven is not None:
            profile = profile.scaled(self._uneven.speed_factor())
        self._control.velocity = profile.velocity
        self._push(self._going_force)
        self.phase, self.until, self._braking = GO, now + profile.go, profile.brake

    def _waypoint(self) -> Position:
        """Return the next position to drive to.

        On the straight way back, a robot that was pushed aside would hit the corner of a wall. If
        it fits between the walls it first drives back beside its line, otherwise back to its line.
        """
        action = self.action
        if not action.gave_up:
            return action.target
        (x, y), (home_x, home_y) = self.position, action.target
        vertical = action.goal[1] == action.home[1]
        to_line, along = ((home_x, y), (x, home_y)) if vertical else ((x, home_y), (home_x, y))
        size = self._spec.cell_size
        aside, away = math.dist((x, y), to_line), math.dist((x, y), along)
        if min(aside, away) <= ARRIVED * size:
            return action.target
        fits = aside < FITTING * (size / 2 - self._spec.radius)
        action.returns += 1
        if action.returns > MAX_RETURNS and action.returns % 2:
            fits = not fits
        return along if fits else to_line

    def _brake(self, now: int, substeps: int) -> None:
        self._control.velocity = (0.0, 0.0)
        self._push(self._braking_force)
        self.phase, self.until = BRAKE, now + substeps

    def _braking_from(self, speed: float) -> int:
        return braking(speed, self._pace, self._spec.time_step)

    def _turn_towards(self, displacement: Cell) -> None:
        """Turn the heading the shorter way round while driving; the way back does not turn it."""
        turn = math.remainder(math.atan2(*displacement) - self._heading, math.tau)
        if turn:
            self._heading += turn
            self._control.angle = self._heading

    def _push(self, force: float) -> None:
        """Let the motor push with up to ``force`` N, or less if motor or floor limit it."""
        self._force = force
        if self._uneven is not None:
            limit = self._uneven.force_limit(self._on, self._spec.motor_force, self._mass)
            force = min(force, limit)
        self._motor.max_force = force

    def _count_work(self, velocity: Position) -> None:
        """Add the work of the motor since the last count: kinetic energy gained, plus drag."""
        energy = 0.5 * self._mass * (velocity[0] ** 2 + velocity[1] ** 2)
        way = math.dist(self._start, self.position)
        self.action.work += max(0.0, energy - self._energy + self._drag * way)
        self._start, self._energy = self.position, energy

    def _has_arrived(self) -> bool:
        return math.dist(self.position, self.action.target) <= ARRIVED * self._spec.cell_size

    def _deadline(self, floor: FloorConditions) -> float:
        """Return the substep after which no new attempt is made."""
        spec = self._spec
        limits = spec.top_speed, self._pace, spec.time_step
        profile = plan_profile((0, 0), (spec.cell_size, 0), *limits)
        return floor.patience * (profile.go + profile.brake)

    def _load(self, loaded: bool, pace: float) -> None:
        """Set the load, and the acceleration in m/s² to drive with."""
        self._loaded, self._pace = loaded, pace
        self._drag = self._nominal_drag = self._spec.drag_force(loaded)
        self.body.mass = self._mass = self._spec.total_mass(loaded)
        self.body.moment = pymunk.moment_for_circle(self._mass, 0.0, self._spec.radius)
        # The floor brakes too; the motor does the rest, so that the pace is the same both ways.
        self._going_force = self._mass * pace + self._nominal_drag
        self._braking_force = max(self._mass * pace - self._nominal_drag, 0.0)
        if self._uneven is not None:
            self._drag *= self._uneven.drag_factor(self._on)
        self._floor.max_force = self._drag
        self._steering.max_force = self.body.moment * MAX_TURN_ACCELERATION
