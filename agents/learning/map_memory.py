"""Memory of an episode as a map, and its view by a network, from the robot in any direction.

A robot remembers the cells that it has seen, how often it has visited each cell, and how often it
has left each cell with each move. When it picks up the item, it forgets its visits and moves,
because its goal changes. The memories of ``B`` robots are arrays, which grow with the floor.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from warehouse_core.copies import CopiedWhole
from warehouse_core.task.encoding import NOWHERE, ObservationArrays
from warehouse_core.world.tables import Flags, Integers
from warehouse_core.world.tiles import CELL_CODES, MOVE_DELTAS, WALL

SingleFloats = NDArray[np.float32]

MOVES = np.array(list(MOVE_DELTAS.values()))
"""Displacements of N, E, S and W, ``[4, 2]``."""

OPPOSITE = np.array([2, 3, 0, 1])
"""Index of the opposite of each move."""

MIRRORED = np.array([0, 3, 2, 1])
"""Indices of the sides (ahead, right, behind, left) after a reflection."""

UNKNOWN, FREE, BLOCKED = 0, 1, 2
"""States of a cell in the map."""

SIDE = 32
"""Initial number of rows and columns of a map."""

MOST = 20
"""Upper limit of differences of counts in a view."""

FAR = 25
"""Upper limit of distances in a view."""

LOGS = np.log1p(np.arange(12)).astype(np.float32)
"""Values in a view for counts of 0, 1, ...; larger counts use the last one."""

BY_MOVE, WINDOWS, REST = 9, 4, 1
"""Number of values in a view for each move, for each cell of the window, and for the whole view."""


WALLS = slice(16, 20)
"""Indices of a view that say whether there are walls in the north, east, south and west."""


def view_size(radius: int) -> int:
    """Return the length of a view, ``L``."""
    return BY_MOVE * len(MOVES) + WINDOWS * (2 * radius + 1) ** 2 + REST


@lru_cache
def turns(radius: int) -> Integers:
    """Return the symmetries of a view as indices into it, ``[2, 4, L]``.

    ``view[turns(radius)[0, d]]`` is the view of a robot that faces in the direction of move ``d``,
    with the cells ahead first. ``view[turns(radius)[1, d]]`` is the mirror image of that view.
    """
    side = 2 * radius + 1
    cells = np.arange(side * side).reshape(side, side)
    views = []
    for is_mirrored in (False, True):
        for move in range(len(MOVES)):
            window, moves = np.rot90(cells, move), np.roll(np.arange(len(MOVES)), -move)
            if is_mirrored:
                window, moves = window[:, ::-1], moves[MIRRORED]
            parts = [len(moves) * kind + moves for kind in range(BY_MOVE)]
            start = len(moves) * BY_MOVE
            parts += [start + window.size * kind + window.ravel() for kind in range(WINDOWS)]
            views.append(np.concatenate([*parts, [start + window.size * WINDOWS]]))
    return np.array(views).reshape(2, len(MOVES), -1)


class MapMemory(CopiedWhole):
    """The memories of ``B`` robots of their episodes.

    Args:
        robots: ``B``.
        view_radius: cells that a robot sees in each direction.
        radius: cells of the map in each direction that a view shows.

    Attributes:
        visits: ``[B]``, number of visits of each robot to its present cell with its present goal.
        beside: ``[B, 4]``, number of its visits to the neighbours in the N, E, S and W.
        is_open: ``[B, 4]``, whether these neighbours are free.

    Example:
        >>> from agents.learning.map_memory import MapMemory, view_size
        >>> from warehouse_core import BatchEnv
        >>> memory = MapMemory(3, view_radius=2, radius=3)
        >>> observation, _ = BatchEnv(3).reset(seed=1)
        >>> memory.look(observation).shape == (3, view_size(3))
        True
    """

    def __init__(self, robots: int, view_radius: int, radius: int) -> None:
        self.view_radius, self.radius = view_radius, radius
        self._robots, self._pad = np.arange(robots), max(view_radius, radius, 1)
        self._allocate(SIDE)
        self._last, self._loaded = np.full((robots, 2), NOWHERE), np.zeros(robots, np.bool_)
        self._came = np.zeros((robots, len(MOVES)), np.bool_)

    def forget(self, robots: Flags) -> None:
        """Forget the episodes of some robots, ``[B]``."""
        for array in (self._map, self._visits, self._exits, self._came):
            array[robots] = 0
        self._last[robots], self._loaded[robots] = NOWHERE, False

    def look(self, arrays: ObservationArrays) -> SingleFloats:
        """Remember the observations of the robots, and return their views, ``[B, L]``.

        A view begins with nine values for each of the four moves:

        1. how much more often the robot has left its cell with it than with the least used move,
        2. how much more often the robot has visited the next cell than the least visited one,
        3. how often the robot has left its cell with it, as a logarithm,
        4. how often the robot has entered its cell from that side, as a logarithm,
        5. whether it leads into a wall,
        6. whether it was the last move,
        7. whether the goal lies in its direction,
        8. how far the goal lies in its direction, and
        9. whether the robot has never left its cell with it.

        Four values for each cell of the window follow: wall, free, visits, goal. The last value is
        the number of visits to the present cell.
        """
        position, loaded = arrays["robot_pos"], np.asarray(arrays["has_item"]) > 0
        while position.max(initial=0) + 2 * self._pad >= self._side:
            self._grow()
        self._forget_visits(loaded != self._loaded)
        self._loaded = loaded
        here = self._numbers(position + self._pad)
        self._count(position, here)
        self._map[self._robots[:, None], here[:, None] + self._offsets(self.view_radius)] = (
            np.where(arrays["local_grid"] == CELL_CODES[WALL], BLOCKED, FREE)
        )
        goal = np.where(loaded[:, None], arrays["dropoff_pos"], arrays["pickup_pos"]) - position
        return self._view(here, goal)

    def _forget_visits(self, robots: Flags) -> None:
        for array in (self._visits, self._exits, self._came):
            array[robots] = 0

    def _count(self, position: Integers, here: Integers) -> None:
        """Count the visits to the present cells, and the moves that led there."""
        made = (position - self._last)[:, None] == MOVES
        moved = np.flatnonzero((self._last != NOWHERE).any(1) & made.all(2).any(1))
        before = self._numbers(self._last[moved] + self._pad)
        self._came[moved] = made[moved].all(2)
        self._exits[moved, before, self._came[moved].argmax(1)] += 1
        self._visits[self._robots, here] += 1
        self._last = position.copy()

    def _view(self, here: Integers, goal: Integers) -> SingleFloats:
        robots, window = self._robots[:, None], here[:, None] + self._offsets(self.radius)
        beside = here[:, None] + self._numbers(MOVES)
        exits, entries = self._exits[self._robots, here], self._exits[robots, beside, OPPOSITE]
        self.visits, self.beside = self._visits[self._robots, here], self._visits[robots, beside]
        self.is_open = self._map[robots, beside] == FREE
        seen = self._map[robots, window]
        ahead = np.maximum(goal @ MOVES.T, 0)
        return np.concatenate(
            [
                *(_over_least(counts, self.is_open) / 4 for counts in (exits, self.beside)),
                *(_logs(counts) for counts in (exits, entries)),
                ~self.is_open,
                self._came,
                ahead > 0,
                np.minimum(ahead, FAR) / 10,
                exits == 0,
                seen == BLOCKED,
                seen == FREE,
                _logs(self._visits[robots, window]),
                (self._cells(self.radius) == goal[:, None]).all(2),
                _logs(self.visits)[:, None],
            ],
            axis=1,
            dtype=np.float32,
        )

    def _cells(self, radius: int) -> Integers:
        """Return the displacements to the cells of a window, ``[K * K, 2]``."""
        span = np.arange(-radius, radius + 1)
        return np.stack(np.meshgrid(span, span, indexing="ij"), axis=2).reshape(-1, 2)

    def _offsets(self, radius: int) -> Integers:
        """Return the cell numbers of a window, relative to the number of its middle."""
        return self._numbers(self._cells(radius))

    def _numbers(self, cells: Integers) -> Integers:
        """Return the numbers of cells in the map, given their rows and columns, ``[..., 2]``."""
        numbers: Integers = cells[..., 0] * self._side + cells[..., 1]
        return numbers

    def _allocate(self, side: int) -> None:
        self._side, shape = side, (len(self._robots), side * side)
        self._map = np.full(shape, UNKNOWN, np.uint8)
        self._visits = np.zeros(shape, np.int32)
        self._exits = np.zeros((*shape, len(MOVES)), np.int32)

    def _grow(self) -> None:
        """Double the number of rows and columns of the maps."""
        side = self._side
        rows, columns = np.divmod(np.arange(side * side), side)
        kept = self._map, self._visits, self._exits
        self._allocate(2 * side)
        places = rows * self._side + columns
        self._map[:, places], self._visits[:, places], self._exits[:, places] = kept


def _over_least(counts: Integers, is_open: Flags) -> SingleFloats:
    """Return by how much each count exceeds the least one of the open cells; 0 if not open."""
    least = np.where(is_open, counts, np.iinfo(np.int32).max).min(axis=1, keepdims=True)
    return np.where(is_open, np.minimum(counts - least, MOST), 0).astype(np.float32)


def _logs(counts: Integers) -> SingleFloats:
    return LOGS[np.minimum(counts, len(LOGS) - 1)]
