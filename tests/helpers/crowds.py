"""Crowds of robots, and the table of ``motion/traffic.py`` applied line by line to each robot."""

import random
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warehouse_core import Cell, Layout
from warehouse_core.motion.base import NOTHING, WALL
from warehouse_core.motion.grid import GridFleetBatch, GridMotion
from warehouse_core.motion.traffic import Obstacle, find_stops
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.tiles import moved

STAY, NORTH, EAST, SOUTH, WEST = (0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)

CASES: dict[str, tuple[list[Cell], list[Cell], list[Obstacle]]] = {
    "waiting": ([(2, 2)], [STAY], [None]),
    "waiting side by side": ([(2, 2), (2, 3)], [STAY, STAY], [None, None]),
    "free": ([(2, 2)], [EAST], [None]),
    "wall": ([(0, 0), (3, 3)], [NORTH, NORTH], ["wall", None]),
    "same target": ([(2, 1), (2, 3)], [EAST, WEST], [1, 0]),
    "same target round a corner": ([(2, 1), (3, 2)], [EAST, NORTH], [1, 0]),
    "three at one": ([(2, 1), (1, 2), (2, 3)], [EAST, SOUTH, WEST], [1, 0, 0]),
    "four at one": ([(2, 1), (1, 2), (2, 3), (3, 2)], [EAST, SOUTH, WEST, NORTH], [1, 0, 0, 0]),
    "head-on": ([(2, 2), (2, 3)], [EAST, WEST], [1, 0]),
    "head-on down a column": ([(2, 2), (3, 2)], [SOUTH, NORTH], [1, 0]),
    "occupied by a waiting robot": ([(2, 2), (2, 3)], [EAST, STAY], [1, None]),
    "queue at a wall": ([(2, 2), (2, 4), (2, 5)], [EAST] * 3, [None, 2, "wall"]),
    "occupied spreads backwards": ([(2, 5), (2, 4), (2, 3)], [EAST] * 3, ["wall", 0, 1]),
    "same target goes first": ([(2, 1), (2, 2), (2, 3)], [EAST, EAST, WEST], [2, 2, 0]),
    "occupied from both sides": (
        [(2, 1), (2, 2), (2, 3), (2, 4)],
        [EAST, STAY, STAY, WEST],
        [1, None, None, 2],
    ),
    "following": ([(2, 1), (2, 2), (2, 3)], [EAST] * 3, [None] * 3),
    "following round a corner": ([(2, 1), (2, 2), (3, 2)], [EAST, SOUTH, SOUTH], [None] * 3),
    "cycle": ([(2, 2), (2, 3), (3, 3), (3, 2)], [EAST, SOUTH, WEST, NORTH], [None] * 4),
    "a fifth robot stops the cycle": (
        [(2, 2), (2, 3), (3, 3), (3, 2), (1, 3)],
        [EAST, SOUTH, WEST, NORTH, SOUTH],
        [4, 2, 3, 0, 0],
    ),
}
"""Cells and moves of robots in a hall of 6 x 6 cells, and what stops each robot by the table."""

LINES = ("waiting", "wall", "same target", "head-on", "occupied", "following", "cycle")
FLOORS, STEPS = 6, 5


def targets_of(cells: Sequence[Cell], moves: Sequence[Cell]) -> list[Cell]:
    return list(map(moved, cells, moves))


def table_line(
    robot: int, layout: Layout, cells: list[Cell], targets: list[Cell]
) -> tuple[str, Obstacle]:
    """Return the line of the table that applies to a robot, and what stops it."""
    line = _line_of_its_own(robot, layout, cells, targets)
    if line is not None:
        return line
    ahead = first = _robot_in(targets[robot], cells)
    while ahead is not None:
        if ahead == robot:
            return "cycle", None
        ahead_line = _line_of_its_own(ahead, layout, cells, targets)
        if ahead_line is not None:
            return "occupied", first
        ahead = _robot_in(targets[ahead], cells)
    return "following", None


def _line_of_its_own(
    robot: int, layout: Layout, cells: list[Cell], targets: list[Cell]
) -> tuple[str, Obstacle] | None:
    """Return the line of a robot that does not depend on whether the one ahead of it moves."""
    cell, target = cells[robot], targets[robot]
    if target == cell:
        return "waiting", None
    if not layout.is_open(target):
        return "wall", "wall"
    for other, its_target in enumerate(targets):
        if other != robot and its_target == target and cells[other] != target:
            return "same target", other
    ahead = _robot_in(target, cells)
    if ahead is not None and targets[ahead] == cell:
        return "head-on", ahead
    return None


def _robot_in(cell: Cell, cells: list[Cell]) -> int | None:
    return cells.index(cell) if cell in cells else None


def array_stops(layout: Layout, cells: list[Cell], moves: list[Cell]) -> list[Obstacle]:
    """Return what stops each robot, according to the arrays of a batch."""
    robots = len(cells)
    batch = GridFleetBatch([layout], 1.0, robots)
    batch.place(np.arange(robots), np.array([row * layout.width + col for row, col in cells]))
    actions = np.array([DISPLACEMENTS.index(move) for move in moves])
    return named(batch.advance(actions, np.zeros(robots, np.bool_)).stopped_by)


def named(stopped_by: NDArray[np.intp]) -> list[Obstacle]:
    """Return the stops of a batch in the form that ``find_stops`` returns."""
    return [{NOTHING: None, WALL: "wall"}.get(stop, stop) for stop in stopped_by.tolist()]


def some_floors(stream: random.Random) -> list[Layout]:
    """Return small floors with few walls or none, and no wall in the first row."""
    height, width = stream.randint(2, 6), stream.randint(2, 8)
    tiles = stream.choice([".", "........#"])
    rows = ["".join(stream.choices(tiles, k=width)) for _ in range((height - 1) * FLOORS)]
    return [Layout(["." * width, *rows[floor::FLOORS]]) for floor in range(FLOORS)]


def ring_action(cell: Cell, layout: Layout) -> int:
    """Return the action that drives clockwise along the border, or a smaller ring inside it."""
    row, col = cell
    south, east = layout.height - 1 - row, layout.width - 1 - col
    inset = min(row, col, south, east)
    if row == inset < east:
        return 1
    if east == inset < south:
        return 2
    return 3 if south == inset < col else 0


def some_actions(cells: list[Cell], layout: Layout, stream: random.Random) -> list[int]:
    """Return an action for each robot: along rings, in one direction, random, or a mixture."""
    direction, alike = stream.randrange(4), stream.choice([0.0, 0.9, 1.0])
    in_rings = stream.random() < 0.5
    return [
        (ring_action(cell, layout) if in_rings else direction)
        if stream.random() < alike
        else stream.randrange(WAIT + 1)
        for cell in cells
    ]


def check_crowds(moves: int, seed: int = 0) -> Counter[str]:
    """Compare ``find_stops`` and the arrays of a batch with the table, for random crowds.

    Return how often each line of the table applied.
    """
    stream, lines = random.Random(seed), Counter[str]()
    while lines.total() < moves:
        layouts = some_floors(stream)
        room = min(len(layout.open_cells) for layout in layouts)
        robots = max(stream.randint(2, room), stream.randint(2, room))
        starts = [stream.sample(layout.open_cells.tolist(), robots) for layout in layouts]
        batch = GridMotion().fleet_batch(layouts, robots)
        batch.place(np.arange(FLOORS * robots), np.ravel(starts))
        for _ in range(STEPS):
            crowds = [
                [divmod(cell, layout.width) for cell in each]
                for each, layout in zip(starts, layouts, strict=True)
            ]
            actions = [some_actions(*each, stream) for each in zip(crowds, layouts, strict=True)]
            outcome = batch.advance(np.ravel(actions), np.zeros(FLOORS * robots, np.bool_))
            for layout, cells, chosen, found in zip(
                layouts, crowds, actions, outcome.stopped_by.reshape(FLOORS, -1), strict=True
            ):
                targets = targets_of(cells, [DISPLACEMENTS[action] for action in chosen])
                table = [table_line(robot, layout, cells, targets) for robot in range(robots)]
                expected = [stop for _, stop in table]
                assert find_stops(layout, cells, targets) == expected
                assert named(found) == expected
                lines.update(line for line, _ in table)
            starts = outcome.cells.reshape(FLOORS, -1).tolist()
    return lines
