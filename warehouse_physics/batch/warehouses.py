"""Many warehouses side by side in one pymunk space, with one robot in each.

A robot is driven by one joint instead of the three in ``robot.py``, with the same motion for a
lone robot, so that a batch reports no headings.
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
"""Solver rounds in a substep. With 2, a robot off its line may stop a substep later after a hit
than with the three joints and 5 rounds of ``robot.py``; with 3 or more it does not."""

SPACING = 3
"""Cells between two layouts: the walls around each, and one more."""


class Warehouses(DrivenArena):
    """``B`` warehouses in one space; positions are relative to the corner of each."""

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout], corners: Floats) -> None:
        super().__init__(spec, ITERATIONS)
        self.space.collision_bias = LONE_BIAS
        self._corners = corners
        self._walls: list[list[pymunk.Shape]] = [[] for _ in layouts]
        self.change_walls(range(len(layouts)), layouts)
        self.add_robots([(0.0, 0.0)] * len(layouts))

    def place(self, row: int, position: Position) -> None:
        """Put a robot at rest at a position, for a new episode.

        The command of its drive need not change, since every action writes it.
        """
        body, (left, top) = self.bodies[row], self._corners[row].tolist()
        body.position = left + position[0], top + position[1]
        body.velocity = (0.0, 0.0)

    def change_walls(self, rows: Sequence[int], layouts: Sequence[Layout]) -> None:
        """Replace the walls of some rows; their robots must be placed before they move."""
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
        """Return positions ``[B, 2]`` in metres and velocities ``[B, 2]`` in m/s."""
        positions, velocities = super().look()
        return positions - self._corners, velocities

    def _note_hits(self, arbiter: pymunk.Arbiter) -> list[Hit]:
        """Return a hit of a wall without impulse and point.

        They would take a tenth of the time of a batch, which does not record contacts.
        """
        row = self._numbers[arbiter.shapes[0]]
        return [Hit(row, None, -arbiter.normal, self.bodies[row].velocity)]


def corners_of(layouts: Sequence[Layout], cell_size: float) -> Floats:
    """Return the position in the space of the corner of each layout, ``[B, 2]`` in metres.

    Layouts are in rows and columns, not in one line, to keep the numbers small and so exact.
    """
    columns = math.isqrt(len(layouts) - 1) + 1
    width = max(layout.width for layout in layouts) + SPACING
    height = max(layout.height for layout in layouts) + SPACING
    down, right = np.divmod(np.arange(len(layouts)), columns)
    return np.stack([right * width, down * height], axis=1) * cell_size
