"""The bodies of ``R`` robots in one layout, each driven by a joint of finite force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import pymunk

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import WALL_CONTACT, centre_of, robot_contact
from warehouse_physics.arena import ITERATIONS, SLOP, add_walls, impulse_of
from warehouse_physics.profile import Floats
from warehouse_physics.robot import ROBOT, WALL, Position
from warehouse_physics.robot_spec import RobotSpec
from warehouse_physics.stepping import Stepper
from warehouse_physics.vector.arena import add_driven_body
from warehouse_physics.vector.body_arrays import BodyArrays
from warehouse_physics.walls import wall_boxes


class Hit(NamedTuple):
    """A robot that has begun to touch something: the wall, or another robot."""

    robot: int
    counterpart: str
    impulse: float
    point: Position


class DrivingArena:
    """A space with the walls of a layout and ``R`` robots, at rest in the middle of their cells.

    The joint that drives a robot exerts the sum of its motor and the drag of the floor. Nothing
    turns a body: the motion of a disc without friction does not depend on its heading.
    """

    def __init__(self, layout: Layout, cells: Sequence[Cell], spec: RobotSpec) -> None:
        self.space = pymunk.Space()
        self.space.iterations = ITERATIONS
        self.space.collision_slop = SLOP
        add_walls(self.space, wall_boxes(layout), spec.cell_size)
        # The control bodies are in a space of their own that is never stepped; see VectorArena.
        self._panel = pymunk.Space()
        self.robots: list[pymunk.Body] = []
        self.drives: list[pymunk.PivotJoint] = []
        self._number: dict[pymunk.Body, int] = {}
        for cell in cells:
            self._add_robot(spec, cell)
        self._bodies, self._controls = BodyArrays(self.space), BodyArrays(self._panel)
        pairs = [(ROBOT, WALL), (ROBOT, ROBOT)]
        self._stepper = Stepper(self.space, spec.time_step, self._note_hit, pairs)

    def look(self) -> tuple[Floats, Floats]:
        """Return positions ``[R, 2]`` in metres and velocities ``[R, 2]`` in m/s."""
        return self._bodies.read()

    def step(self, velocities: Floats) -> list[Hit]:
        """Command velocities ``[R, 2]`` in m/s for a substep; return the hits that begin in it."""
        self._controls.write_velocities(velocities)
        _, pairs = self._stepper.run(0, 1)
        return [hit for pair in pairs for hit in pair]

    def _add_robot(self, spec: RobotSpec, cell: Cell) -> None:
        place = centre_of(cell, spec.cell_size)
        body, _, drive = add_driven_body(self.space, self._panel, spec, place)
        self._number[body] = len(self.robots)
        self.robots.append(body)
        self.drives.append(drive)

    def _note_hit(self, arbiter: pymunk.Arbiter) -> list[Hit]:
        """Return the hit as each robot in it feels it."""
        one, other = arbiter.bodies
        points = arbiter.contact_point_set
        impulse = impulse_of(one, other, points.normal.dot(one.velocity - other.velocity))
        x, y = points.points[0].point_a
        hits = []
        for body, met in ((one, other), (other, one)):
            robot, counterpart = self._number.get(body), self._number.get(met)
            if robot is not None:
                name = WALL_CONTACT if counterpart is None else robot_contact(counterpart)
                hits.append(Hit(robot, name, impulse, (x, y)))
        return hits
