"""A space with walls, in which bodies with numbers move, and the hits between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np
import pymunk

from warehouse_core.motion.base import SCAN_RANGE, WALL_CONTACT, Contact, robot_contact
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec
from warehouse_physics.stepping import Stepper
from warehouse_physics.walls import CellBox

Position = tuple[float, float]

ROBOT, WALL = 1, 2
"""Collision types. Chipmunk puts the body of the lower one first in a hit."""

ITERATIONS = 5
"""Solver rounds in a substep, unless an arena needs more or can do with fewer."""

SLOP = 0.001
"""Metres that bodies may overlap. Chipmunk's default of 0.1 is meant for pixels."""

LONE_BIAS = 0.0
"""Share of an overlap that is left after a second, where each robot is alone. All of it is
corrected while the robot still brakes; spread over several substeps, as by default, the correction
would add to the way back."""


class Hit(NamedTuple):
    """The begin of a touch, as one robot feels it.

    Attributes:
        other: number of the robot that it touches, or ``None`` for a wall.
        push: direction ``(x, y)`` of the push on the robot, of length 1.
        velocity: velocity of the robot right before the hit, in m/s.
        impulse: impulse in N·s, see ``Contact``; not a number if it was not measured.
        point: position of the touch in metres; likewise.
    """

    robot: int
    other: int | None
    push: Position
    velocity: pymunk.Vec2d
    impulse: float = math.nan
    point: Position = (math.nan, math.nan)

    def contact(self, seconds: float) -> Contact:
        """Return the record of this hit, which happened at a time."""
        name = WALL_CONTACT if self.other is None else robot_contact(self.other)
        return Contact(seconds, self.impulse, self.point, name)


class Arena:
    """A space for the walls and robots of one or more warehouses.

    ``iterations`` are solver rounds in a substep; ``bodies`` are in the order of their numbers.
    """

    def __init__(self, spec: RobotSpec, iterations: int) -> None:
        self.space = pymunk.Space()
        self.space.iterations = iterations
        self.space.collision_slop = SLOP
        self.bodies: list[pymunk.Body] = []
        self._numbers: dict[pymunk.Shape, int] = {}
        self._spec = spec
        pairs = [(ROBOT, WALL), (ROBOT, ROBOT)]
        self.stepper = Stepper(self.space, spec.time_step, self._note_hits, pairs)

    def add_walls(
        self, boxes: Iterable[CellBox], corner: Position = (0.0, 0.0)
    ) -> list[pymunk.Shape]:
        """Add walls, given as boxes in cells from a corner in metres, and return their shapes."""
        walls: list[pymunk.Shape] = []
        size, (left_edge, top_edge) = self._spec.cell_size, corner
        for left, top, right, bottom in boxes:
            corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
            vertices = [(left_edge + x * size, top_edge + y * size) for x, y in corners]
            shape = pymunk.Poly(self.space.static_body, vertices)
            shape.collision_type = WALL
            self.space.add(shape)
            walls.append(shape)
        return walls

    def add_robot(self, body: pymunk.Body, *joined: pymunk.Body | pymunk.Constraint) -> None:
        """Add the body of the next robot as a disc, and what is joined to it.

        The order matters: the same robots added in another one move differently in the last bits.
        """
        shape = pymunk.Circle(body, self._spec.body_radius)
        shape.collision_type = ROBOT
        shape.filter = group_of(len(self.bodies))
        self._numbers[shape] = len(self.bodies)
        self.bodies.append(body)
        self.space.add(body, shape, *joined)

    def scan(self, robot: int, rays: int) -> Floats:
        """Return how far walls and other robots are from a robot; see ``BaseMotion.scan``."""
        start, distances = self.bodies[robot].position, np.full(rays, SCAN_RANGE)
        own = group_of(robot)
        for ray, way in enumerate(ways_of(rays)):
            hit = self.space.segment_query_first(start, start + way, 0.0, own)
            if hit is not None:
                distances[ray] = hit.alpha * SCAN_RANGE
        return distances

    def _note_hits(self, arbiter: pymunk.Arbiter) -> list[Hit]:
        """Return a hit as each robot in it feels it, before the solver changes any velocity."""
        contacts = arbiter.contact_point_set
        normal, (x, y) = contacts.normal, contacts.points[0].point_a
        robot, other = map(self._numbers.get, arbiter.shapes)
        assert robot is not None
        body = self.bodies[robot]
        if other is None:
            impulse = impulse_of(normal.dot(body.velocity), self._mass(robot, normal))
            return [Hit(robot, None, -normal, body.velocity, impulse, (x, y))]
        met = self.bodies[other]
        masses = self._mass(robot, normal), self._mass(other, normal)
        impulse = impulse_of(normal.dot(body.velocity - met.velocity), *masses)
        return [
            Hit(robot, other, -normal, body.velocity, impulse, (x, y)),
            Hit(other, robot, normal, met.velocity, impulse, (x, y)),
        ]

    def _mass(self, robot: int, normal: pymunk.Vec2d) -> float:
        """Return the mass in kg with which a robot resists a push along ``normal``."""
        return self.bodies[robot].mass


@cache
def ways_of(rays: int) -> list[pymunk.Vec2d]:
    """Return the way in metres from the first end of each ray of a scan to its last."""
    return [pymunk.Vec2d(SCAN_RANGE, 0.0).rotated(math.tau * ray / rays) for ray in range(rays)]


def group_of(robot: int) -> pymunk.ShapeFilter:
    """Return the group that only this robot is in, whose shapes do not meet each other.

    A ray from the middle of a robot in its group meets all but this robot.
    """
    return pymunk.ShapeFilter(group=robot + 1)


def impulse_of(speed: float, mass: float, other_mass: float | None = None) -> float:
    """Return the impulse in N·s of a body that hits another one, or a wall, with ``speed``.

    They do not bounce, so the hit takes all of that speed from their reduced mass. What the solver
    counts has more in it: the push of motors, of robots behind them, and after a touch within the
    last substeps also the impulse of the earlier touch.
    """
    reduced = mass if other_mass is None else mass * other_mass / (mass + other_mass)
    return max(reduced * speed, 0.0)
