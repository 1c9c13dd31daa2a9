"""The physics of one episode: walls and robots in a pymunk space."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import pymunk

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import WALL_CONTACT, Contact, robot_contact
from warehouse_physics.disturbances import FloorConditions
from warehouse_physics.robot import ROBOT, WALL, Position, Robot, Touch
from warehouse_physics.robot_spec import ARRIVED, RobotSpec
from warehouse_physics.stepping import Stepper
from warehouse_physics.walls import Box, wall_boxes

ITERATIONS = 5
"""Solver rounds in a substep of one robot."""

SLOP = 0.001
"""Metres that bodies may overlap. Chipmunk's default of 0.1 is meant for pixels."""

BIAS = 0.0
"""Share of an overlap that is left after a second, where a robot is alone. All of it is corrected
while the robot still brakes; over several substeps, as by default, it adds to the way back."""


class Hit(NamedTuple):
    """Two bodies that have begun to touch, and their velocities in m/s right before."""

    bodies: tuple[pymunk.Body, pymunk.Body]
    normal: pymunk.Vec2d
    point: pymunk.Vec2d
    velocities: tuple[pymunk.Vec2d, pymunk.Vec2d]


class Arena:
    """A space with the walls of a layout and ``R`` robots, which start in ``cells``."""

    def __init__(
        self,
        layout: Layout,
        cells: Sequence[Cell],
        spec: RobotSpec,
        floor: FloorConditions | None = None,
    ) -> None:
        self.space = pymunk.Space()
        usual = ITERATIONS if len(cells) == 1 else iterations_for_jams(spec)
        self.space.iterations = max(usual, iterations_for_drag(spec))
        self.space.collision_slop = SLOP
        if len(cells) == 1:
            self.space.collision_bias = BIAS
        self._step = spec.time_step
        add_walls(self.space, wall_boxes(layout), spec.cell_size)
        self._robot_of: dict[pymunk.Body, Robot] = {}
        self.robots = [Robot(self.space, spec, cell, self._robot_of, floor) for cell in cells]
        self._varies = floor is not None and floor.varies
        pairs = [(ROBOT, WALL), (ROBOT, ROBOT)]
        self._stepper = Stepper(self.space, spec.time_step, _note_hit, pairs)

    def run(self, now: int, until: int) -> int:
        """Step from substep ``now`` to ``until`` or the first hit; return the last substep done."""
        while now < until:
            now, hits = self._stepper.run(now, now + 1 if self._varies else until)
            if self._varies:
                for robot in self.robots:
                    robot.feel_floor()
            if hits:
                self._report_hits(hits, now)
                break
        return now

    def _report_hits(self, hits: list[Hit], now: int) -> None:
        """Pass the hits of this substep to the robots, with the velocities after them."""
        for (one, two), normal, point, velocities in hits:
            impulse = impulse_of(one, two, normal.dot(velocities[0] - velocities[1]))
            for body, other, sign, velocity in (
                (one, two, -1.0, velocities[0]),
                (two, one, 1.0, velocities[1]),
            ):
                robot, met = self._robot_of.get(body), self._robot_of.get(other)
                if robot is not None:
                    name = WALL_CONTACT if met is None else robot_contact(met.number)
                    contact = Contact(now * self._step, impulse, (point[0], point[1]), name)
                    push = sign * normal[0], sign * normal[1]
                    robot.meet(now, Touch(met, push, velocity), contact)


def iterations_for_jams(spec: RobotSpec) -> int:
    """Return the solver rounds that several robots of this kind need, 5 for the default one.

    Robots that push each other converge the more slowly the more their masses differ: with 5 rounds
    for all, about one of 20,000 robots in jams with heavy loads stays stuck.
    """
    return 3 + math.ceil(spec.total_mass(loaded=True) / spec.mass)


def iterations_for_drag(spec: RobotSpec) -> int:
    """Return the solver rounds that a robot of this kind needs for its drag.

    The drag of the floor and the motor, which has to overcome it, each grow by what the other did,
    up to the momentum of the commanded speed in a round. The lowest one is that of a correction
    over ``ARRIVED``.
    """
    slowest = math.sqrt(spec.attainable_acceleration(loaded=True) * ARRIVED * spec.cell_size)
    return 3 + math.ceil(spec.floor_deceleration * spec.time_step / slowest)


def add_walls(
    space: pymunk.Space, boxes: Iterable[Box], size: float, corner: Position = (0.0, 0.0)
) -> list[pymunk.Shape]:
    """Add walls, given as boxes in cells of ``size`` metres from ``corner``; return them."""
    walls: list[pymunk.Shape] = []
    left_edge, top_edge = corner
    for left, top, right, bottom in boxes:
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        vertices = [(left_edge + x * size, top_edge + y * size) for x, y in corners]
        shape = pymunk.Poly(space.static_body, vertices)
        shape.collision_type = WALL
        space.add(shape)
        walls.append(shape)
    return walls


def _note_hit(arbiter: pymunk.Arbiter) -> Hit:
    bodies = arbiter.bodies
    points = arbiter.contact_point_set
    velocities = bodies[0].velocity, bodies[1].velocity
    return Hit(bodies, points.normal, points.points[0].point_a, velocities)


def impulse_of(body: pymunk.Body, other: pymunk.Body, speed: float) -> float:
    """Return the impulse in N·s of a hit between two bodies that approach with ``speed``.

    They do not bounce, so the hit takes all of that speed from their reduced mass. What the solver
    counts has more in it: the push of motors, of robots behind them, and after a touch within the
    last substeps also that of the earlier touch.
    """
    is_wall = other.body_type == pymunk.Body.STATIC
    mass = body.mass if is_wall else body.mass * other.mass / (body.mass + other.mass)
    return max(mass * speed, 0.0)
