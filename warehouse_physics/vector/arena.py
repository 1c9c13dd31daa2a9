"""Many warehouses side by side in one pymunk space, with one robot in each.

A robot is driven by one joint instead of the three in ``robot.py``, with the same motion for a
lone robot. The joint exerts the sum of motor force and floor drag. Nothing turns the robot: the
motion of a disc without friction does not depend on its heading, and a batch reports none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pymunk

from warehouse_core import Layout
from warehouse_physics.arena import BIAS, SLOP, add_walls
from warehouse_physics.profile import Floats
from warehouse_physics.robot import ROBOT, WALL, Position
from warehouse_physics.robot_spec import RobotSpec
from warehouse_physics.stepping import Stepper
from warehouse_physics.vector.body_arrays import BodyArrays
from warehouse_physics.walls import Box, wall_boxes

ITERATIONS = 3
"""Solver rounds in a substep. With 2, a robot off its line may stop a substep later after a hit
than with the three joints and 5 rounds of ``robot.py``; with 3 or more it does not."""

APART = 3
"""Cells between two layouts: the walls around each, and one more."""


class Hit(NamedTuple):
    """A robot that has begun to touch a wall, ``push`` and ``velocity`` as in ``Touch``."""

    row: int
    push: Position
    velocity: Position


class VectorArena:
    """``B`` warehouses in one space; positions are relative to the corner of each.

    Args:
        spec: of the robots.
        layouts: the warehouses.
        corners: ``[B, 2]`` metres, their positions in the space; see ``corners_of``.

    Attributes:
        robots: their bodies.
        drives: the joint that drives each robot; its ``max_force`` limits the force in N.
    """

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout], corners: Floats) -> None:
        self.space = pymunk.Space()
        self.space.iterations = ITERATIONS
        self.space.collision_slop = SLOP
        self.space.collision_bias = BIAS
        self._corners, self._cell_size = corners, spec.cell_size
        self._walls: list[list[pymunk.Shape]] = [[] for _ in layouts]
        self.change_walls(range(len(layouts)), layouts)
        # The control bodies are in a space of their own that is never stepped: joints use their
        # velocities, and their positions do not matter.
        self._panel = pymunk.Space()
        self.robots: list[pymunk.Body] = []
        self.drives: list[pymunk.PivotJoint] = []
        self._row: dict[pymunk.Shape, int] = {}
        for row in range(len(layouts)):
            self._row[self._add_robot(spec)] = row
        self._bodies, self._controls = BodyArrays(self.space), BodyArrays(self._panel)
        self._stepper = Stepper(self.space, spec.time_step, self._note_hit, [(ROBOT, WALL)])

    def place(self, row: int, position: Position) -> None:
        """Put a robot at rest at a position, for a new episode.

        The command of its drive need not change, since every action writes it.
        """
        body, (left, top) = self.robots[row], self._corners[row].tolist()
        body.position = left + position[0], top + position[1]
        body.velocity = (0.0, 0.0)

    def change_walls(self, rows: Sequence[int], layouts: Sequence[Layout]) -> None:
        """Replace the walls of some rows; their robots must be placed before they move."""
        known: dict[int, list[Box]] = {}
        for row, layout in zip(rows, layouts, strict=True):
            # Layouts with the same walls share this array; see ``Layout.with_stations``.
            key = id(layout.open_cells)
            if key not in known:
                known[key] = wall_boxes(layout)
            self.space.remove(*self._walls[row])
            corner = self._corners[row].tolist()
            self._walls[row] = add_walls(self.space, known[key], self._cell_size, corner)

    def command(self, velocities: Floats) -> None:
        """Set the velocities ``[B, 2]`` in m/s for the drives to reach."""
        self._controls.write_velocities(velocities)

    def look(self) -> tuple[Floats, Floats]:
        """Return positions ``[B, 2]`` in metres and velocities ``[B, 2]`` in m/s."""
        positions, velocities = self._bodies.read()
        return positions - self._corners, velocities

    def run(self, now: int, until: int) -> tuple[int, list[Hit]]:
        """Step from substep ``now`` to ``until`` or the first hits; return when, and the hits."""
        return self._stepper.run(now, until)

    def _add_robot(self, spec: RobotSpec) -> pymunk.Shape:
        body, shape, drive = add_driven_body(self.space, self._panel, spec)
        self.robots.append(body)
        self.drives.append(drive)
        return shape

    def _note_hit(self, arbiter: pymunk.Arbiter) -> Hit:
        row = self._row[arbiter.shapes[0]]
        return Hit(row, -arbiter.normal, self.robots[row].velocity)


def add_driven_body(
    space: pymunk.Space, panel: pymunk.Space, spec: RobotSpec, position: Position = (0.0, 0.0)
) -> tuple[pymunk.Body, pymunk.Shape, pymunk.PivotJoint]:
    """Add a robot to a space that one joint drives, and its control body to ``panel``."""
    # A body with an infinite moment never turns.
    body = pymunk.Body(spec.mass, math.inf)
    body.position = position
    shape = pymunk.Circle(body, spec.body_radius)
    shape.collision_type = ROBOT
    control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    drive = pymunk.PivotJoint(body, control, (0, 0), (0, 0))
    # Errors of position are not corrected: the joint is a motor, not a spring.
    drive.error_bias = 1.0
    panel.add(control)
    space.add(body, shape, drive)
    return body, shape, drive


def corners_of(layouts: Sequence[Layout], cell_size: float) -> Floats:
    """Return the position in the space of the corner of each layout, ``[B, 2]`` in metres.

    Layouts are in rows and columns, not in one line, to keep the numbers small and so exact.
    """
    columns = math.isqrt(len(layouts) - 1) + 1
    width = max(layout.width for layout in layouts) + APART
    height = max(layout.height for layout in layouts) + APART
    down, right = np.divmod(np.arange(len(layouts)), columns)
    return np.stack([right * width, down * height], axis=1) * cell_size
