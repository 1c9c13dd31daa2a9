"""The bodies of ``B`` warehouses in pymunk, with one robot in each, pushed by forces.

Up to ``ROWS_OF_A_SPACE`` warehouses share a space, too far apart to touch. A lone warehouse has a
space of its own, in which other bodies may be pushed, jointed and hit. Nothing is commanded here
but forces: positions and velocities of bodies are only read.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from warehouse_core import Layout
from warehouse_core.motion.base import SCAN_RANGE, WALL_CONTACT
from warehouse_physics.arena import (
    ROBOT,
    Arena,
    Position,
    group_of,
    impulse_of,
    ray_vectors,
)
from warehouse_physics.batch.rigid_body_batch import ROWS_OF_A_SPACE
from warehouse_physics.batch.warehouses import corners_of
from warehouse_physics.drive.drives import BodyState, Thrust
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec
from warehouse_physics.walls import wall_boxes

ITERATIONS = 10
"""Solver iterations in a substep. Robots that push each other's boxes against walls need more than
robots that only meet walls."""

LONE_ITERATIONS = 3
"""Solver iterations if there is nothing but robots and walls."""

BIAS = 0.0
"""Share of an overlap that remains after a second: overlaps are corrected at once."""

UNKNOWN = (math.nan, math.nan)
"""Point of a contact in a space of many warehouses, which do not record contacts."""

SEEN = BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
GIVEN = BodyFields.FORCE | BodyFields.TORQUE


class Bump(NamedTuple):
    """The beginning of a contact of a robot.

    Attributes:
        row: number of the robot.
        impulse: impulse in N·s, see ``Contact``.
        point: position of the contact in metres.
        counterpart: name of what was hit, such as ``"wall"``.
    """

    row: int
    impulse: float
    point: Position
    counterpart: str


class DriveArena(Arena):
    """A space with the walls of ``rows`` warehouses and a robot in each.

    Attributes:
        walls: shapes of the walls.
        names: name of each shape that is neither a robot nor a wall, for records of contacts.
    """

    def __init__(
        self, spec: RobotSpec, layout: Layout, first: int, corners: Floats, *, is_alone: bool
    ) -> None:
        super().__init__(spec, ITERATIONS if is_alone else LONE_ITERATIONS, [(ROBOT, None)])
        self.space.collision_bias = BIAS
        self.names: dict[pymunk.Shape, str] = {}
        self._first, self._is_alone = first, is_alone
        boxes = wall_boxes(layout)
        self.walls = {
            wall for corner in corners.tolist() for wall in self.add_walls(boxes, tuple(corner))
        }
        for _ in corners:
            self.add_robot(pymunk.Body(spec.mass, math.inf))
        self._seen, self._given = Buffer(), Buffer()
        self._pushes = np.zeros((len(corners) + 1, 3))  # the static body comes last
        self._given.set_float_buf(self._pushes)

    def read(self) -> Floats:
        """Return ``[6, rows]``: x, y, angle, both velocities and the turn rate of the robots."""
        self._seen.clear()
        get_space_bodies(self.space, SEEN, self._seen)
        # A copy is needed because the next read fills the same memory.
        seen = np.frombuffer(self._seen.float_buf()).reshape(-1, 6)
        return seen[: len(self.bodies)].T.copy()

    def step(self, forces: Floats, torques: Floats) -> list[Bump]:
        """Thrust the robots for one substep and return the contacts that have begun."""
        if self._is_alone:  # Other bodies keep the forces that somebody else applies to them.
            [body], [[ahead], [aside]], [torque] = self.bodies, forces.tolist(), torques.tolist()
            right, down = body.force
            body.force = right + ahead, down + aside
            body.torque += torque
        else:
            self._pushes[:-1, :2], self._pushes[:-1, 2] = forces.T, torques
            set_space_bodies(self.space, GIVEN, self._given)
        return self.stepper.run(0, 1)[1]

    def scan(self, robot: int, rays: int) -> Floats:
        """Return the distances in metres to what is not a sensor, ``[K]``; ray 0 is ahead."""
        body, own = self.bodies[robot], group_of(robot)
        distances = np.empty(rays)
        for number, ray in enumerate(ray_vectors(rays)):
            end = body.position + ray.rotated(body.angle)
            hits = self.space.segment_query(body.position, end, 0.0, own)
            shares = [hit.alpha for hit in hits if hit.shape is not None and not hit.shape.sensor]
            distances[number] = SCAN_RANGE * min(shares, default=1.0)
        return distances

    def _note_hits(self, arbiter: pymunk.Arbiter) -> list[Bump]:  # type: ignore[override]
        """Return the contact of a robot before the solver changes any velocity."""
        robot, other = arbiter.shapes
        if not self._is_alone:  # Only walls can be hit, and nobody records the point.
            row = self._numbers[robot]
            hit = self.bodies[row]
            impulse = impulse_of(arbiter.normal.dot(hit.velocity), hit.mass)
            return [Bump(self._first + row, impulse, UNKNOWN, WALL_CONTACT)]
        if robot.sensor or other.sensor:
            return []
        normal, body, met = arbiter.normal, robot.body, other.body
        assert body is not None
        assert met is not None
        is_moving = met.body_type == pymunk.Body.DYNAMIC
        speed = normal.dot(body.velocity - met.velocity)
        impulse = impulse_of(speed, body.mass, met.mass if is_moving else None)
        is_static = met.body_type == pymunk.Body.STATIC
        name = self.names.get(other, WALL_CONTACT if is_static else "body")
        point = arbiter.contact_point_set.points[0].point_a
        return [Bump(self._first + self._numbers[robot], impulse, point, name)]


class DriveBodies:
    """The robots of ``B`` warehouses with the same walls.

    Attributes:
        arenas: spaces with up to ``ROWS_OF_A_SPACE`` warehouses each.
        corners: ``[B, 2]`` metres, position of each warehouse in its space.
    """

    def __init__(self, spec: RobotSpec, layout: Layout, rows: int) -> None:
        self._spec = spec
        first = range(0, rows, ROWS_OF_A_SPACE)
        sizes = [min(ROWS_OF_A_SPACE, rows - start) for start in first]
        corners = [corners_of([layout] * size, spec.cell_size) for size in sizes]
        self.corners = np.concatenate(corners)
        self.arenas = [
            DriveArena(spec, layout, start, places, is_alone=rows == 1)
            for start, places in zip(first, corners, strict=True)
        ]
        self._slices = [
            slice(start, start + size) for start, size in zip(first, sizes, strict=True)
        ]
        self._bodies = [body for arena in self.arenas for body in arena.bodies]

    def body(self, row: int) -> pymunk.Body:
        """Return the body of a robot."""
        return self._bodies[row]

    def place(self, row: int, position: Position, mass: float) -> None:
        """Put a robot at rest at a position, facing east."""
        body, (left, top) = self._bodies[row], self.corners[row].tolist()
        body.position, body.velocity = (left + position[0], top + position[1]), (0.0, 0.0)
        body.angle = body.angular_velocity = 0.0
        self.load(row, mass)

    def load(self, row: int, mass: float) -> None:
        """Set the mass of a robot in kg. A disc that is pushed in any direction never turns."""
        body, spec = self._bodies[row], self._spec
        body.mass = mass
        body.moment = mass * spec.radius**2 / 2 if spec.is_differential else math.inf

    def read(self) -> BodyState:
        """Return where the robots are, relative to their warehouses, and how they move."""
        parts = [arena.read() for arena in self.arenas]
        seen = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        seen[:2] -= self.corners.T
        return BodyState(seen[:2].T, seen[2], seen[3:5].T, seen[5])

    def step(self, push: Thrust) -> list[Bump]:
        """Thrust all robots for one substep and return the contacts that have begun."""
        bumps: list[Bump] = []
        for arena, rows in zip(self.arenas, self._slices, strict=True):
            bumps += arena.step(push.forces[:, rows], push.torques[rows])
        return bumps
