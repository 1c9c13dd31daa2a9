"""Many warehouses next to each other in one pymunk space, with one robot in each.

One joint drives a robot here instead of the three in ``robot.py``. A lone robot moves in the same
way with both, except that bodies here have no heading.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pymunk

from warehouse_core import Layout
from warehouse_physics.arena import LONE_BIAS, Hit, Position
from warehouse_physics.driven_arena import DrivenArena
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec
from warehouse_physics.walls import CellBox, wall_boxes

ITERATIONS = 3
"""Solver iterations in a substep. With 2, a robot that is off its line may stop a substep later
after a hit than with the three joints and 5 iterations of ``robot.py``. With 3 or more it does not.
"""

SPACING = 3
"""Cells between two layouts: the wall around each of them, and one more cell."""


class Warehouses(DrivenArena):
    """``B`` warehouses in one space. Positions are relative to the corner of each warehouse."""

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout], corners: Floats) -> None:
        super().__init__(spec, ITERATIONS)
        self.space.collision_bias = LONE_BIAS
        self._corners = corners
        self._walls: list[list[pymunk.Shape]] = [[] for _ in layouts]
        self.change_walls(range(len(layouts)), layouts)
        self.add_robots([(0.0, 0.0)] * len(layouts))

    def place(self, row: int, position: Position) -> None:
        """Put a robot at rest at a position, for a new episode.

        The command of its drive need not be reset, since every action writes it.
        """
        body, (left, top) = self.bodies[row], self._corners[row].tolist()
        body.position = left + position[0], top + position[1]
        body.velocity = (0.0, 0.0)

    def change_walls(self, rows: Sequence[int], layouts: Sequence[Layout]) -> None:
        """Replace the walls of some rows; their robots have to be placed before they move."""
        known: dict[int, list[CellBox]] = {}
        for row, layout in zip(rows, layouts, strict=True):
            # Layouts with the same walls share this array; see ``Layout.with_stations``.
            key = id(layout.open_cells)
            if key not in known:
                known[key] = wall_boxes(layout)
            self.space.remove(*self._walls[row])
            left, top = self._corners[row].tolist()
            self._walls[row] = self.add_walls(known[key], (left, top))

    def look(self) -> tuple[Floats, Floats]:
        """Return the positions ``[B, 2]`` in metres and the velocities ``[B, 2]`` in m/s."""
        positions, velocities = super().look()
        return positions - self._corners, velocities

    def _note_hits(self, arbiter: pymunk.Arbiter) -> list[Hit]:
        """Return a hit with a wall, without its impulse and its point.

        Calculating them would take a tenth of the time of a batch, which does not record contacts.
        """
        row = self._numbers[arbiter.shapes[0]]
        return [Hit(row, None, -arbiter.normal, self.bodies[row].velocity)]


def corners_of(layouts: Sequence[Layout], cell_size: float) -> Floats:
    """Return the position of the corner of each layout in the space, ``[B, 2]`` in metres.

    The layouts are arranged in a grid and not in one line, because smaller coordinates are more
    exact.
    """
    columns = math.isqrt(len(layouts) - 1) + 1
    width = max(layout.width for layout in layouts) + SPACING
    height = max(layout.height for layout in layouts) + SPACING
    down, right = np.divmod(np.arange(len(layouts)), columns)
    return np.stack([right * width, down * height], axis=1) * cell_size
