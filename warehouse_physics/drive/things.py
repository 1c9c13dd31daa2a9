"""What is in a warehouse besides walls and the robot: crates, people, obstacles and other bodies.

*Crates* are boxes that a robot pushes. Friction with the floor slows them down, and a crate that
touches a wall blocks the robot. *People* walk at random; see ``people.py``. *Obstacles* are pillars
and polygons that never move. Bodies of users come from a function ``on_reset(space)``, or are added
to the space by hand.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pymunk

from warehouse_core import Cell, Layout, LayoutError
from warehouse_core.arguments import as_cell, real_number, whole_number
from warehouse_core.motion.base import centre_of
from warehouse_core.motion.grid import GRAVITY
from warehouse_core.wording import brief
from warehouse_core.world.layout import check_open
from warehouse_core.world.tiles import WALL as WALL_TILE
from warehouse_core.world.tiles import manhattan_distance
from warehouse_physics.arena import WALL
from warehouse_physics.drive.bodies import DriveArena
from warehouse_physics.drive.people import Person
from warehouse_physics.spec import RobotSpec

CRATE_SIDE, CRATE_MASS, CRATE_FRICTION = 0.5, 15.0, 0.2
"""Side of a crate as a share of a cell, its mass in kg and its friction coefficient with the floor.
The default robot can push one crate, and two in a row, but not three."""

TURNING_ARM = 0.38
"""Mean distance of a square's area from its middle, as a share of its side. Friction resists turns
with this lever."""

Shapes = Sequence[Any]


class Things:
    """The crates, people, obstacles and bodies of users in one warehouse.

    Args:
        crates: number of crates in random cells, or their cells.
        people: number of people, who start in random cells.
        obstacles: pillars ``(x, y, radius)`` and convex polygons ``[(x, y), ...]``, in metres.
        on_reset: function that is called with each new space.
        most: largest number of crates, and of people.

    Raises:
        ValueError: an argument is out of range.
        TypeError: an argument has the wrong type.
    """

    def __init__(
        self,
        crates: int | Sequence[Cell] = 0,
        people: int = 0,
        obstacles: Shapes = (),
        on_reset: Callable[[pymunk.Space], object] | None = None,
        *,
        most: int,
    ) -> None:
        self.crates: int | tuple[Cell, ...] = (
            whole_number("crates", crates, 0, most)
            if isinstance(crates, (int, np.integer))
            else _crates(crates)
        )
        self.people = whole_number("people", people, 0, most)
        self.obstacles = [_obstacle(each) for each in _listed(obstacles)]
        if on_reset is not None and not callable(on_reset):
            raise TypeError(f"on_reset is {brief(on_reset)}; it must be a function of a space")
        self._on_reset = on_reset
        self.are_own = bool(self.obstacles) or on_reset is not None
        self.are_own |= not isinstance(self.crates, int) and bool(self.crates)

    @property
    def exist(self) -> bool:
        """Whether there is anything besides walls and robots."""
        return bool(self.crates or self.people) or self.are_own

    def fill(
        self, arena: DriveArena, spec: RobotSpec, crates: Sequence[Cell], people: Sequence[Person]
    ) -> None:
        """Put all things into a new space, with crates in these cells."""
        for number, cell in enumerate(crates):
            arena.names[add_crate(arena.space, centre_of(cell, spec.cell_size), spec)] = (
                f"crate {number}"
            )
        for number, person in enumerate(people):
            arena.names[person.shape] = f"person {number}"
            arena.space.add(person.body, person.shape)
        for number, obstacle in enumerate(self.obstacles):
            shape = obstacle(arena.space.static_body)
            shape.collision_type = WALL
            arena.space.add(shape)
            arena.names[shape] = f"obstacle {number}"
        if self._on_reset is not None:
            self._on_reset(arena.space)

    def cells(self, layout: Layout, start: Cell, seed: int) -> Sequence[Cell]:
        """Return the cells of the crates, which leave a path to all stations if they are random.

        Raises:
            LayoutError: there is no room for the crates.
        """
        if not isinstance(self.crates, int):
            for cell in self.crates:
                check_open(layout, cell, "crates")
                if cell == start:
                    raise LayoutError(f"crates has {cell}, which is the start of the robot")
            return self.crates
        stations = {*layout.pickups, *layout.dropoffs}
        free = [
            cell
            for cell in layout.cells(layout.open_cells)
            if cell != start and cell not in stations
        ]
        stream, chosen = random.Random(f"{seed} crates"), list[Cell]()
        stream.shuffle(free)
        for cell in free:
            if len(chosen) == self.crates:
                break
            if stations <= _with_walls(layout, [*chosen, cell]).reachable_from(start):
                chosen.append(cell)
        if len(chosen) < self.crates:
            raise LayoutError(
                f"crates is {self.crates}; only {len(chosen)} fit without blocking a station"
            )
        return chosen

    def people_in(self, layout: Layout, taken: Iterable[Cell], seed: int) -> list[Cell]:
        """Return the cells of the people, outside of cells that are taken and their neighbours.

        Raises:
            LayoutError: there is no room for the people.
        """
        far = [
            cell
            for cell in layout.cells(layout.open_cells)
            if all(manhattan_distance(cell, other) > 1 for other in taken)
        ]
        if len(far) < self.people:
            raise LayoutError(f"people is {self.people}; only {len(far)} fit into the layout")
        return random.Random(f"{seed} people").sample(far, self.people)


def add_crate(space: pymunk.Space, position: tuple[float, float], spec: RobotSpec) -> pymunk.Shape:
    """Add a crate at rest, with the friction of the floor, and return its shape."""
    side = CRATE_SIDE * spec.cell_size
    body = pymunk.Body(CRATE_MASS, pymunk.moment_for_box(CRATE_MASS, (side, side)))
    body.position = position
    shape = pymunk.Poly.create_box(body, (side, side))
    force = CRATE_FRICTION * CRATE_MASS * GRAVITY
    floor = pymunk.PivotJoint(space.static_body, body, (0, 0), (0, 0))
    twist = pymunk.GearJoint(space.static_body, body, 0.0, 1.0)
    for joint, most in ((floor, force), (twist, force * TURNING_ARM * side)):
        joint.max_bias, joint.max_force = 0.0, most
    space.add(body, shape, floor, twist)
    return shape


def _with_walls(layout: Layout, cells: Sequence[Cell]) -> Layout:
    rows = [list(row) for row in layout.rows]
    for row, col in cells:
        rows[row][col] = WALL_TILE
    return Layout(["".join(row) for row in rows])


def _crates(given: Any) -> tuple[Cell, ...]:
    try:
        return tuple(as_cell("crates", cell) for cell in given)
    except Exception:  # a user's ``__iter__`` may raise anything
        raise ValueError(
            f"crates is {brief(given)}; it must be a number, or cells (row, column)"
        ) from None


def _listed(obstacles: Any) -> list[Any]:
    try:
        return list(obstacles)
    except Exception:  # a user's ``__iter__`` may raise anything
        raise TypeError(f"obstacles is {brief(obstacles)}; it must be a list") from None


def _obstacle(given: Any) -> Callable[[pymunk.Body], pymunk.Shape]:
    """Return a function that makes the shape of a pillar or polygon on a body."""
    try:
        parts = list(given)
        if len(parts) == 3 and all(isinstance(part, (int, float)) for part in parts):
            x, y, radius = (real_number("obstacle", part) for part in parts)
            radius = real_number("radius of an obstacle", radius, above=True)
            return lambda body: pymunk.Circle(body, radius, (x, y))
        corners = [(real_number("x", x), real_number("y", y)) for x, y in parts]
    except (TypeError, ValueError) as error:
        raise type(error)(
            f"obstacles has {brief(given)}; it must be (x, y, radius) or a list of corners (x, y), "
            f"in metres: {error}"
        ) from None
    if len(corners) < 3 or not math.isfinite(sum(map(sum, corners))):
        raise ValueError(f"obstacles has {brief(given)}; a polygon needs at least 3 corners")
    return lambda body: pymunk.Poly(body, corners)
