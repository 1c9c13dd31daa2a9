"""People who walk through a warehouse from cell to cell.

A person is a heavy disc that does not know what the robot wants. It walks to the middle of a
neighbouring cell and then on to another one, which is random, and goes back only from a dead end.
It stops for a robot that is close ahead. After it has been held up for a while, it chooses another
cell.
"""

from __future__ import annotations

import random
from typing import Any

import pymunk

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import centre_of
from warehouse_core.world.tiles import MOVE_DELTAS
from warehouse_physics.spec import RobotSpec

MASS, RADIUS = 75.0, 0.25
"""Mass of a person in kg, and radius as a share of a cell."""

SPEED, ACCELERATION = 0.6, 2.0
"""Walking speed in m/s, and largest acceleration in m/s², which limits how hard people push."""

NEAR = 0.5
"""Distance in cells between the rims of a person and a robot ahead below which the person stops."""

PATIENCE = 3.0
"""A person turns after this many times the duration of a free walk to the next cell."""

ARRIVED = 0.05
"""Distance from the middle of a cell, in cells, at which a person has arrived."""


class Person:
    """A person who starts in the middle of a cell and walks at random, as ``seed`` determines."""

    def __init__(
        self, layout: Layout, spec: RobotSpec, robot: pymunk.Body, cell: Cell, seed: str
    ) -> None:
        self._layout, self._spec, self._robot = layout, spec, robot
        self._stream = random.Random(seed)
        self._before = self._target = cell
        self._waited = 0.0
        self.body = pymunk.Body(MASS, float("inf"))
        self.body.position = centre_of(cell, spec.cell_size)
        self.body.velocity_func = self._walk
        self.shape = pymunk.Circle(self.body, RADIUS * spec.cell_size)

    def _walk(self, body: pymunk.Body, gravity: Any, damping: float, dt: float) -> None:
        """Change the velocity of the body in a substep; Chipmunk calls this."""
        size = self._spec.cell_size
        self._waited += dt
        if self._to_target().length < ARRIVED * size:
            self._turn(self._target, self._before)
        elif self._waited > PATIENCE * size / SPEED:
            x, y = body.position  # A robot may have pushed the person into another cell.
            self._turn((int(y // size), int(x // size)), self._target)
        ahead = self._to_target()
        wanted = ahead.normalized() * (0.0 if self._is_held_up(ahead) else SPEED)
        change, most = wanted - body.velocity, ACCELERATION * dt
        body.velocity += change if change.length <= most else change.scale_to_length(most)

    def _to_target(self) -> pymunk.Vec2d:
        """Return the vector to the middle of the next cell, in metres."""
        to_x, to_y = centre_of(self._target, self._spec.cell_size)
        return pymunk.Vec2d(to_x, to_y) - self.body.position

    def _turn(self, here: Cell, avoided: Cell) -> None:
        """Choose a cell next to ``here``, if possible not the one that is to be avoided."""
        row, col = here
        around = [(row + down, col + right) for down, right in MOVE_DELTAS.values()]
        free = [cell for cell in around if self._layout.is_open(cell)]
        wanted = [cell for cell in free if cell != avoided]
        self._before, self._waited = here, 0.0
        self._target = self._stream.choice(wanted or free or [here])

    def _is_held_up(self, ahead: pymunk.Vec2d) -> bool:
        """Return whether the robot is close ahead."""
        apart = self._robot.position - self.body.position
        reach = self._spec.radius + (RADIUS + NEAR) * self._spec.cell_size
        return apart.length < reach and apart.dot(ahead) > 0
