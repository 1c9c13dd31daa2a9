"""The world of one episode: walls and robots in a pymunk space, stepped to the next event."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import pymunk

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import WALL_CONTACT, Contact, robot_contact
from warehouse_physics.disturbances import Floor
from warehouse_physics.robot import ROBOT, WALL, Position, Robot, Touch
from warehouse_physics.robot_spec import RobotSpec
from warehouse_physics.walls import Box, wall_boxes

ITERATIONS = 5
"""Rounds of the solver in a substep; enough for a lone robot, whose joints do not fight."""

FLEET_ITERATIONS = 15

SLOP = 0.001
"""Metres that bodies may overlap. Chipmunk's own 0.1 is meant for pixels."""


class Arena:
    """A space with the walls of a layout and ``R`` robots.

    Args:
        layout: whose walls to build.
        cells: where the robots start.
        spec: what they are made of.
        floor: what disturbs them, or ``None``.
    """

    def __init__(
        self, layout: Layout, cells: Sequence[Cell], spec: RobotSpec, floor: Floor | None = None
    ) -> None:
        self.space = pymunk.Space()
        self.space.iterations = ITERATIONS if len(cells) == 1 else FLEET_ITERATIONS
        self.space.collision_slop = SLOP
        self._step = spec.time_step
        add_walls(self.space, wall_boxes(layout), spec.cell_size)
        self.robots = [Robot(self.space, spec, cell, floor) for cell in cells]
        self._is_uneven = floor is not None
        self._number = {robot.body: number for number, robot in enumerate(self.robots)}
        for robot in self.robots:
            robot.touching = partial(self.touching, robot)
        self._hits: list[tuple[Any, ...]] = []
        self.space.on_collision(ROBOT, WALL, begin=self._note_hit)
        self.space.on_collision(ROBOT, ROBOT, begin=self._note_hit)

    def run(self, now: int, until: int) -> int:
        """Step from substep ``now`` to ``until`` or to the first hit, and return which it is."""
        step = self._step_and_feel if self._is_uneven else self.space.step
        dt, hits = self._step, self._hits
        for substep in range(now + 1, until + 1):
            step(dt)
            if hits:
                self._report_hits(substep)
                return substep
        return until

    def _step_and_feel(self, dt: float) -> None:
        """Step once, and let the robots feel the floor that they have got to."""
        self.space.step(dt)
        for robot in self.robots:
            robot.feel_floor()

    def touching(self, robot: Robot) -> list[Robot]:
        """Return the robots that touch ``robot``."""
        bodies: list[pymunk.Body] = []
        robot.body.each_arbiter(lambda arbiter: bodies.extend(arbiter.bodies))
        numbers = sorted({self._number[body] for body in bodies if body in self._number})
        return [self.robots[number] for number in numbers if self.robots[number] is not robot]

    def _note_hit(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Remember a hit as it begins, before the solver changes any velocity."""
        bodies = arbiter.bodies
        points = arbiter.contact_point_set
        self._hits.append(
            (bodies, points.normal, points.points[0].point_a, [body.velocity for body in bodies])
        )

    def _report_hits(self, now: int) -> None:
        """Tell the robots of the hits of this substep, once their impulses are known."""
        hits = self._hits.copy()
        self._hits.clear()
        for bodies, normal, point, velocities in hits:
            numbers = [self._number.get(body) for body in bodies]
            impulse = _impulse_between(*bodies)
            for number, other, sign, velocity in (
                (numbers[0], numbers[1], -1.0, velocities[0]),
                (numbers[1], numbers[0], 1.0, velocities[1]),
            ):
                if number is not None:
                    name = WALL_CONTACT if other is None else robot_contact(other)
                    contact = Contact(now * self._step, impulse, (point[0], point[1]), name)
                    push: Position = (sign * normal[0], sign * normal[1])
                    met = None if other is None else self.robots[other]
                    self.robots[number].meet(now, Touch(met, push, velocity), contact)


def add_walls(
    space: pymunk.Space, boxes: Iterable[Box], size: float, corner: Position = (0.0, 0.0)
) -> None:
    """Add walls, given as boxes in cells of ``size`` metres from a position on."""
    left_edge, top_edge = corner
    for left, top, right, bottom in boxes:
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        vertices = [(left_edge + x * size, top_edge + y * size) for x, y in corners]
        shape = pymunk.Poly(space.static_body, vertices)
        shape.collision_type = WALL
        space.add(shape)


def _impulse_between(body: pymunk.Body, other: pymunk.Body) -> float:
    """Return the impulse in N·s with which two bodies met in the last substep."""
    found = [0.0]

    def look(arbiter: pymunk.Arbiter) -> None:
        if set(arbiter.bodies) == {body, other}:
            found.append(arbiter.total_impulse.length)

    body.each_arbiter(look)
    return max(found)
