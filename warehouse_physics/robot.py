"""One robot: a body with mass, the motor that drives it, and the floor that drags at it.

The motor is a joint of finite force to a control body whose velocity is written; it is the only
thing that is ever commanded. Position and velocity of the robot itself are only read.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

import pymunk

from warehouse_core import Cell
from warehouse_core.motion.base import Contact, centre_of
from warehouse_physics.disturbances import Floor
from warehouse_physics.profile import braking, plan_leg
from warehouse_physics.robot_spec import ARRIVED, RobotSpec

Position = tuple[float, float]

ROBOT, WALL = 1, 2
"""Collision types."""

TURN_RATE, TURNING = math.pi, 60.0
"""Angular speed and acceleration of the heading, in rad/s and rad/s²; no disc goes elsewhere."""

AT_REST = 1e-9
"""Speed in m/s below which a robot stands still."""

AGAINST = 0.3
"""How much of a push must be against the way to count as being in the way."""


PAUSE = 0.5
"""Seconds that a robot waits on its way back for one that came after it and goes back first."""

MOST_WAITS = 20

MOST_RETURNS = 8
"""Legs of a way back after which a robot is stuck and tries the other way every other time."""

FITTING = 0.9
"""Share of the room beside a robot in its lane that it may use up."""


NEVER = sys.maxsize
"""The substep at which a robot at rest has something to do."""

MOST_SUBSTEPS = 10_000
"""After so many substeps an action ends, wherever the robots are."""


class Phase(Enum):
    """What the drive is doing."""

    REST = 0
    GO = 1
    BRAKE = 2


class Touch(NamedTuple):
    """What a robot feels of a hit: the robot that it met, if it was one, and a push."""

    other: Robot | None
    push: Position
    """Direction of the push on this robot, of length 1."""
    velocity: Position
    """Of this robot right before the hit, m/s."""


class Robot:
    """A robot in a space.

    Args:
        space: that its body and joints are added to.
        spec: what it is made of.
        cell: where it starts, at rest and heading east.
        floor: what disturbs it, or ``None``.
    """

    def __init__(
        self, space: pymunk.Space, spec: RobotSpec, cell: Cell, floor: Floor | None = None
    ) -> None:
        self._spec, self._uneven = spec, floor
        self.body = pymunk.Body(spec.mass, _moment(spec, loaded=False))
        self.body.position = centre_of(cell, spec.cell_size)
        shape = pymunk.Circle(self.body, spec.radius)
        shape.collision_type = ROBOT
        self._control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self._floor = pymunk.PivotJoint(space.static_body, self.body, (0, 0), (0, 0))
        self._motor = pymunk.PivotJoint(self.body, self._control, (0, 0), (0, 0))
        self._steering = pymunk.GearJoint(self.body, self._control, 0.0, 1.0)
        self._floor.max_bias = self._motor.max_bias = 0.0
        self._steering.max_bias = TURN_RATE
        # The motor comes after the floor: the last word in the solver's round is the drive's.
        space.add(self.body, shape, self._control, self._floor, self._motor, self._steering)
        self.gave_up = self._returning = False
        self.touching: Callable[[], list[Robot]] = list
        self._heading = 0.0
        self.look()
        self._on = cell
        self._loaded: bool | None = None
        self._load(False, spec.acceleration)
        self._brake(0, 0)
        self.phase, self.until = Phase.REST, NEVER

    def look(self) -> None:
        """Read where the middle of the body is, in metres."""
        x, y = self.body.position
        self.position = x, y

    @property
    def cell(self) -> Cell:
        """The cell that the middle of the body was over at the last look."""
        x, y = self.position
        return math.floor(y / self._spec.cell_size), math.floor(x / self._spec.cell_size)

    def set_out(self, displacement: Cell, loaded: bool, pace: float) -> None:
        """Begin an action: drive to the middle of a cell, or back if something is in the way.

        Args:
            displacement: ``(0, 0)``, or one cell in one direction.
            loaded: whether it carries an item.
            pace: acceleration in m/s² to drive with.
        """
        if loaded != self._loaded or pace != self._pace:
            self._load(loaded, pace)
        self.look()
        row, col = self.home = self.cell
        self.goal = goal = (row + displacement[0], col + displacement[1])
        self.gave_up, self._waits, self._returns = False, 0, 0
        self.contacts: list[Contact] = []
        self.work = 0.0
        self._target = centre_of(goal, self._spec.cell_size)
        self._deadline = math.inf if self._uneven is None else self._patience(self._uneven)
        if goal != self.home:
            self._turn_towards(displacement)
            self._go(0)

    def next_phase(self, now: int) -> None:
        """Do what comes next at substep ``now``: brake, or drive on if it is not there yet."""
        self.look()
        if self.phase is Phase.GO:
            self._count_work(self.body.velocity)
            self._brake(now, self._braking)
            return
        speed = math.hypot(*self.body.velocity)
        if speed > AT_REST:
            self._brake(now, self._braking_from(speed))
        elif now >= self._deadline or self._has_arrived():
            self.phase, self.until = Phase.REST, NEVER
        elif self.gave_up and self._must_wait(now):
            self._give_way(now)
        else:
            self._go(now)

    def meet(self, now: int, touch: Touch, contact: Contact) -> None:
        """Take note of a hit at substep ``now``, and give up if it is in the way."""
        self.contacts.append(contact)
        self.look()
        if self.phase is Phase.GO:
            self._count_work(touch.velocity)
        if self._is_hindered_by(touch):
            self.give_up(now)
        elif self.phase is not Phase.GO:
            self._brake(now, self._braking_from(self.body.velocity.length))
        elif self._returning and touch.other is not None and touch.other.came_after(self):
            self._give_way(now)

    def give_up(self, now: int) -> None:
        """Brake at substep ``now`` and drive back to where the action began."""
        self.gave_up = True
        self._target = centre_of(self.home, self._spec.cell_size)
        self._brake(now, self._braking_from(self.body.velocity.length))

    def feel_floor(self) -> None:
        """Take account of the floor under the robot, where that differs from cell to cell."""
        self.look()
        cell = self.cell
        if self._uneven is not None and cell != self._on:
            if self.phase is Phase.GO:
                self._count_work(self.body.velocity)
            self._on = cell
            self._drag = self._nominal_drag * self._uneven.drag_factor(cell)
            self._floor.max_force = self._drag
            self._push(self._force)

    def came_after(self, other: Robot) -> bool:
        """Say whether this robot set out for the cell that ``other`` set out from, not head-on."""
        return self.goal == other.home != self.home != other.goal

    def _must_wait(self, now: int) -> bool:
        """Make those who touch this robot and came after it give up, and let them go first.

        They may have come to touch before it was clear that this robot has to go back. Robots in a
        ring would wait for each other for ever, hence the limit.
        """
        followers = [robot for robot in self.touching() if robot.came_after(self)]
        for robot in followers:
            if not robot.gave_up:
                robot.give_up(now)
        self._waits += 1
        return bool(followers) and self._waits <= MOST_WAITS

    def _give_way(self, now: int) -> None:
        """Stand without brakes for a while, so that the other can push past."""
        self._brake(now, round(PAUSE / self._spec.time_step))
        self._push(0.0)

    def _is_hindered_by(self, touch: Touch) -> bool:
        """Say whether a touch is against the way, or of a robot that wants its own cell back."""
        if self.gave_up or self.goal == self.home:
            return False
        other = touch.other
        if other is not None and other.gave_up:
            if self.came_after(other):
                return True
            # Pushed aside by a third, it goes back to where it is not in the way.
            if self.goal not in (other.home, other.goal):
                return False
        down, right = self.goal[0] - self.home[0], self.goal[1] - self.home[1]
        return touch.push[0] * right + touch.push[1] * down < -AGAINST

    def _go(self, now: int) -> None:
        spec, self._start, self._energy = self._spec, self.position, 0.0
        self._returning = self.gave_up or self.goal == self.home
        leg = plan_leg(self._start, self._waypoint(), spec.top_speed, self._pace, spec.time_step)
        if self._uneven is not None:
            leg = leg.scaled(self._uneven.speed_factor())
        self._control.velocity = leg.velocity
        self._push(self._going_force)
        self.phase, self.until, self._braking = Phase.GO, now + leg.go, leg.brake

    def _waypoint(self) -> Position:
        """Return where to drive next on the way back.

        A robot that was pushed aside would run into the corner of a wall on the straight way. Where
        it fits past the walls it first goes back beside its line, elsewhere back to its line.
        """
        if not self.gave_up:
            return self._target
        (x, y), (home_x, home_y) = self.position, self._target
        vertical = self.goal[1] == self.home[1]
        to_line, along = ((home_x, y), (x, home_y)) if vertical else ((x, home_y), (home_x, y))
        size = self._spec.cell_size
        aside, away = math.dist((x, y), to_line), math.dist((x, y), along)
        if min(aside, away) <= ARRIVED * size:
            return self._target
        fits = aside < FITTING * (size / 2 - self._spec.radius)
        self._returns += 1
        if self._returns > MOST_RETURNS and self._returns % 2:
            fits = not fits
        return along if fits else to_line

    def _brake(self, now: int, substeps: int) -> None:
        self._control.velocity = (0.0, 0.0)
        self._push(self._braking_force)
        self.phase, self.until = Phase.BRAKE, now + substeps

    def _braking_from(self, speed: float) -> int:
        return braking(speed, self._pace, self._spec.time_step)

    def _turn_towards(self, displacement: Cell) -> None:
        """Turn the heading, the shorter way round, while driving; back it drives as it stands."""
        turn = math.remainder(math.atan2(*displacement) - self._heading, math.tau)
        if turn:
            self._heading += turn
            self._control.angle = self._heading

    def _push(self, force: float) -> None:
        """Let the motor push with up to ``force`` N, or with what it and the floor allow."""
        self._force = force
        if self._uneven is not None:
            limit = self._uneven.force_limit(self._on, self._spec.motor_force, self._mass)
            force = min(force, limit)
        self._motor.max_force = force

    def _count_work(self, velocity: Position) -> None:
        """Add what the motor has done since it was counted: speed gained, and drag overcome."""
        energy = 0.5 * self._mass * (velocity[0] ** 2 + velocity[1] ** 2)
        way = math.dist(self._start, self.position)
        self.work += max(0.0, energy - self._energy + self._drag * way)
        self._start, self._energy = self.position, energy

    def _has_arrived(self) -> bool:
        return math.dist(self.position, self._target) <= ARRIVED * self._spec.cell_size

    def _patience(self, floor: Floor) -> float:
        """Return after how many substeps no new attempt is made."""
        spec = self._spec
        leg = plan_leg((0, 0), (spec.cell_size, 0), spec.top_speed, self._pace, spec.time_step)
        return floor.patience * (leg.go + leg.brake)

    def _load(self, loaded: bool, pace: float) -> None:
        """Take account of a load, and of the acceleration in m/s² to drive with."""
        self._loaded, self._pace = loaded, pace
        self._drag = self._nominal_drag = self._spec.drag_force(loaded)
        self.body.mass = self._mass = self._spec.total_mass(loaded)
        self.body.moment = _moment(self._spec, loaded)
        # The floor brakes too; the motor does the rest, so that the pace is the same both ways.
        self._going_force = self._mass * pace + self._nominal_drag
        self._braking_force = max(self._mass * pace - self._nominal_drag, 0.0)
        if self._uneven is not None:
            self._drag *= self._uneven.drag_factor(self._on)
        self._floor.max_force = self._drag
        self._steering.max_force = self.body.moment * TURNING


def _moment(spec: RobotSpec, loaded: bool) -> float:
    """Return the moment of inertia of a solid disc in kg·m²."""
    return pymunk.moment_for_circle(spec.total_mass(loaded), 0.0, spec.radius)
