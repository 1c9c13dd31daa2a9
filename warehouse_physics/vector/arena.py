"""Warehouses side by side in one space, a lone robot in each, stepped to the next event.

A robot is driven as in ``robot.py`` but by one joint where that has three, which leaves the motion
of a lone robot as it is. The joint pushes with what the motor and the drag of the floor come to
together, and nothing turns the robot: a disc without friction goes the same way whatever its
heading, and a batch reports none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pymunk

from warehouse_core import Layout
from warehouse_physics.arena import SLOP, add_walls
from warehouse_physics.profile import Floats
from warehouse_physics.robot import ROBOT, WALL, Position
from warehouse_physics.robot_spec import RobotSpec
from warehouse_physics.vector.body_arrays import BodyArrays
from warehouse_physics.walls import Box, wall_boxes

ITERATIONS = 3
"""Rounds of the solver in a substep. With 2 a robot off its line may stand a substep later after a
hit than with the three joints and 5 rounds of ``robot.py``; with 3 or more it does not."""

APART = 3
"""Cells between two layouts: the walls around each, and one more."""


class Hit(NamedTuple):
    """A robot that has begun to touch a wall."""

    row: int
    push: Position
    """Direction of the push on the robot, of length 1."""
    velocity: Position
    """Of the robot right before the hit, m/s."""


class Yard:
    """``B`` warehouses in one space. Positions are relative to the corner of each.

    Args:
        spec: what the robots are made of.
        layouts: whose walls to build, ``B`` of them.
    """

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout]) -> None:
        self.space = pymunk.Space()
        self.space.iterations = ITERATIONS
        self.space.collision_slop = SLOP
        self._step = spec.time_step
        self._corners = _corners(layouts, spec.cell_size)
        self._build_walls(layouts, spec.cell_size)
        # The control bodies stand in a space of their own that is never stepped: a joint feels
        # their velocity, and where they are means nothing.
        self._panel = pymunk.Space()
        self.robots: list[pymunk.Body] = []
        self._joints: list[pymunk.PivotJoint] = []
        self._row: dict[pymunk.Shape, int] = {}
        for row in range(len(layouts)):
            self._row[self._add_robot(spec)] = row
        self._bodies, self._controls = BodyArrays(self.space), BodyArrays(self._panel)
        self._hits: list[Hit] = []
        self.space.on_collision(ROBOT, WALL, begin=self._note_hit)

    def place(self, row: int, position: Position) -> None:
        """Put a robot at rest somewhere, for a new episode.

        What its drive is commanded need not change: every action writes that anew.
        """
        body, (left, top) = self.robots[row], self._corners[row].tolist()
        body.position = left + position[0], top + position[1]
        body.velocity = (0.0, 0.0)

    def load(self, row: int, mass: float) -> None:
        """Set the mass of a robot in kg."""
        self.robots[row].mass = mass

    def push(self, row: int, force: float) -> None:
        """Let the drive of a robot push with up to ``force`` N."""
        self._joints[row].max_force = force

    def command(self, velocities: Floats) -> None:
        """Set the velocities ``[B, 2]`` in m/s that the drives push towards."""
        self._controls.write_velocities(velocities)

    def look(self) -> tuple[Floats, Floats]:
        """Return positions ``[B, 2]`` in metres and velocities ``[B, 2]`` in m/s."""
        positions, velocities = self._bodies.read()
        return positions - self._corners, velocities

    def run(self, now: int, until: int) -> tuple[int, list[Hit]]:
        """Step from substep ``now`` to ``until`` or to the first hits; return which, and them."""
        step, dt, hits = self.space.step, self._step, self._hits
        for substep in range(now + 1, until + 1):
            step(dt)
            if hits:
                self._hits = []
                return substep, hits
        return until, []

    def _build_walls(self, layouts: Sequence[Layout], size: float) -> None:
        known: dict[int, list[Box]] = {}
        for layout, corner in zip(layouts, self._corners.tolist(), strict=True):
            # Layouts with the same walls share this array; see Layout.with_stations.
            key = id(layout.open_cells)
            if key not in known:
                known[key] = wall_boxes(layout)
            add_walls(self.space, known[key], size, corner)

    def _add_robot(self, spec: RobotSpec) -> pymunk.Shape:
        # Nothing turns a body whose moment is not finite.
        body = pymunk.Body(spec.mass, math.inf)
        shape = pymunk.Circle(body, spec.radius)
        shape.collision_type = ROBOT
        control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        drive = pymunk.PivotJoint(body, control, (0, 0), (0, 0))
        # All of an error of position is left as it is: a motor, not a spring.
        drive.error_bias = 1.0
        self._panel.add(control)
        self.space.add(body, shape, drive)
        self.robots.append(body)
        self._joints.append(drive)
        return shape

    def _note_hit(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Remember a hit as it begins, before the solver changes any velocity."""
        row = self._row[arbiter.shapes[0]]
        self._hits.append(Hit(row, -arbiter.normal, self.robots[row].velocity))


def _corners(layouts: Sequence[Layout], cell_size: float) -> Floats:
    """Return where in the space the corner of each layout is, ``[B, 2]`` in metres.

    In rows and columns rather than in one line, which keeps the numbers small and so exact.
    """
    columns = math.isqrt(len(layouts) - 1) + 1
    width = max(layout.width for layout in layouts) + APART
    height = max(layout.height for layout in layouts) + APART
    down, right = np.divmod(np.arange(len(layouts)), columns)
    return np.stack([right * width, down * height], axis=1) * cell_size
