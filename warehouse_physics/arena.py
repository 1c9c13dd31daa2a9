"""A pymunk space with walls and numbered robots, and the hits between them.

A robot is a disc, and a wall is a rectangle that never moves. There is no friction between bodies
and they do not bounce. When two of them begin to touch, Chipmunk calls back before it changes any
velocity, so that the speed of the impact is still known. ``Arena`` then records a ``Hit`` for each
robot that takes part, and the run of substeps ends, so that the robots can react.

Nothing looks at the grid to find out whether a robot is blocked. A wall blocks a robot because
their shapes touch.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
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
"""Collision types of shapes. In a hit, Chipmunk passes the body with the lower type first."""

PAIRS = ((ROBOT, WALL), (ROBOT, ROBOT))
"""Collision types between which hits are noted by default."""

ITERATIONS = 5
"""Default number of solver iterations in a substep. Some arenas need more, others need fewer."""

SLOP = 0.001
"""Depth in metres to which bodies may overlap. Chipmunk's default of 0.1 is meant for pixels."""

LONE_BIAS = 0.0
"""Share of an overlap that remains after a second, for robots that are alone in their warehouse.
With 0 an overlap is corrected at once, while the robot still brakes. By default Chipmunk spreads
the correction over several substeps, and this would lengthen the drive back."""


class Hit(NamedTuple):
    """The beginning of a contact, as seen by one of its robots.

    Attributes:
        robot: number of the robot.
        other: number of the other robot, or ``None`` for a wall.
        push: direction ``(x, y)`` in which the robot is pushed, as a vector of length 1.
        velocity: velocity of the robot immediately before the hit, in m/s.
        impulse: impulse in N·s, see ``Contact``; NaN if it was not measured.
        point: position of the contact in metres; NaN if it was not measured.
    """

    robot: int
    other: int | None
    push: Position
    velocity: pymunk.Vec2d
    impulse: float = math.nan
    point: Position = (math.nan, math.nan)

    def contact(self, seconds: float) -> Contact:
        """Return the record of this hit for an ``Outcome``, ``seconds`` after the action began."""
        name = WALL_CONTACT if self.other is None else robot_contact(self.other)
        return Contact(seconds, self.impulse, self.point, name)


class Arena:
    """A space with the walls and robots of one or more warehouses.

    ``iterations`` is the number of solver iterations in a substep. ``pairs`` has the collision
    types between which hits are noted, where ``None`` stands for all types. ``bodies`` has the
    bodies of the robots in the order of their numbers.
    """

    def __init__(
        self, spec: RobotSpec, iterations: int, pairs: Sequence[tuple[int, int | None]] = PAIRS
    ) -> None:
        self.space = pymunk.Space()
        self.space.iterations = iterations
        self.space.collision_slop = SLOP
        self.bodies: list[pymunk.Body] = []
        self._numbers: dict[pymunk.Shape, int] = {}
        self._spec = spec
        self.stepper = Stepper(self.space, spec.time_step, self._note_hits, pairs)

    def add_walls(
        self, boxes: Iterable[CellBox], corner: Position = (0.0, 0.0)
    ) -> list[pymunk.Shape]:
        """Add walls and return their shapes.

        The boxes are in cells, relative to a corner that is given in metres.
        """
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
        """Add the next robot as a disc around ``body``, with its other bodies and its joints.

        The order of the calls matters: robots that are added in another order move differently in
        the last bits.
        """
        shape = pymunk.Circle(body, self._spec.body_radius)
        shape.collision_type = ROBOT
        shape.filter = group_of(len(self.bodies))
        self._numbers[shape] = len(self.bodies)
        self.bodies.append(body)
        self.space.add(body, shape, *joined)

    def scan(self, robot: int, rays: int) -> Floats:
        """Return the distances from a robot to walls and other robots; see ``BaseMotion.scan``."""
        start, distances = self.bodies[robot].position, np.full(rays, SCAN_RANGE)
        own = group_of(robot)
        for number, ray in enumerate(ray_vectors(rays)):
            hit = self.space.segment_query_first(start, start + ray, 0.0, own)
            if hit is not None:
                distances[number] = hit.alpha * SCAN_RANGE
        return distances

    def _note_hits(self, arbiter: pymunk.Arbiter) -> list[Hit]:
        """Return a hit for each robot in a contact, before the solver changes any velocity."""
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
def ray_vectors(rays: int) -> list[pymunk.Vec2d]:
    """Return the vector in metres from the start to the end of each ray of a scan."""
    return [pymunk.Vec2d(SCAN_RANGE, 0.0).rotated(math.tau * ray / rays) for ray in range(rays)]


def group_of(robot: int) -> pymunk.ShapeFilter:
    """Return a collision filter for a group that contains this robot only.

    Shapes in the same group do not collide. A ray that starts in the middle of a robot, with the
    filter of this robot, therefore hits everything except the robot itself.
    """
    return pymunk.ShapeFilter(group=robot + 1)


def impulse_of(speed: float, mass: float, other_mass: float | None = None) -> float:
    """Return the impulse in N·s of a body that hits a wall or another body at ``speed`` in m/s.

    The bodies do not bounce. A hit therefore removes their whole closing speed, and the impulse is
    this speed times their reduced mass. The impulse that the solver counts is larger: it includes
    the push of motors and of robots behind, and the impulse of an earlier contact between the same
    bodies a few substeps ago.
    """
    reduced = mass if other_mass is None else mass * other_mass / (mass + other_mass)
    return max(reduced * speed, 0.0)
