"""What robots remember of an episode, and how a network sees it: from the robot, in any direction.

A robot remembers the cells that it has seen, how often it has been in each, and how often it has
left each by each move. Visits are forgotten when it picks up the item, since it then has another
goal. ``B`` robots remember side by side, in arrays that grow with the floor.
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
"""Number of the opposite of each move."""

MIRRORED = np.array([0, 3, 2, 1])
"""Number of what is ahead, to the right, behind and to the left, in a mirror."""

UNKNOWN, FREE, BLOCKED = 0, 1, 2
"""Marks of a cell in the map."""

SIDE = 32
"""Rows and columns of a map at first."""

MOST = 20
"""Differences of counts above this one look alike."""

FAR = 25
"""Distances above this one look alike."""

LOGS = np.log1p(np.arange(12)).astype(np.float32)
"""Numbers for counts of 0, 1, ...; those beyond the last look alike."""

BY_MOVE, WINDOWS, REST = 9, 4, 1
"""Kinds of numbers in a view: one for each move, one for each cell of the window, one alone."""


WALLS = slice(16, 20)
"""Numbers of a view that say whether there are walls in the north, east, south and west."""


def view_size(radius: int) -> int:
    """Return the number of numbers in a view, ``L``."""
    return BY_MOVE * len(MOVES) + WINDOWS * (2 * radius + 1) ** 2 + REST


@lru_cache
def turns(radius: int) -> Integers:
    """Return the symmetries of a view as indices into it, ``[2, 4, L]``.

    ``view[turns(radius)[0, d]]`` is the view of a robot that looks in the direction of move ``d``,
    with what is ahead first; ``view[turns(radius)[1, d]]`` is that view in a mirror.
    """
    side = 2 * radius + 1
    cells = np.arange(side * side).reshape(side, side)
    found = []
    for is_mirrored in (False, True):
        for move in range(len(MOVES)):
            window, moves = np.rot90(cells, move), np.roll(np.arange(len(MOVES)), -move)
            if is_mirrored:
                window, moves = window[:, ::-1], moves[MIRRORED]
            parts = [len(moves) * kind + moves for kind in range(BY_MOVE)]
            start = len(moves) * BY_MOVE
            parts += [start + window.size * kind + window.ravel() for kind in range(WINDOWS)]
            found.append(np.concatenate([*parts, [start + window.size * WINDOWS]]))
    return np.array(found).reshape(2, len(MOVES), -1)


class MapMemory(CopiedWhole):
    """What ``B`` robots remember of their episodes.

    Args:
        robots: ``B``.
        view_radius: cells that a robot sees in each direction.
        radius: cells of the map in each direction that a view shows.

    Attributes:
        visits: ``[B]``, how often each robot has been where it is, for its present goal.
        beside: ``[B, 4]``, how often it has been in the cells to which N, E, S and W lead.
        is_open: ``[B, 4]``, whether these cells are free.

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
        """Remember what the robots observe, and return their views, ``[B, L]``.

        A view has nine numbers for each move: how much more often the robot has left by it, and
        has been in the cell beyond, than by the least used move; how often it has left and come
        that way; whether there is a wall; whether it was the last move; whether the goal lies
        there, and how far; whether the robot has never left by it. Then it has four numbers for
        each cell of the window: wall, free, visits, goal. The last number is the visits here.
        """
        position, loaded = arrays["robot_pos"], np.asarray(arrays["has_item"]) > 0
        while position.max(initial=0) + 2 * self._pad >= self._side:
            self._grow()
        self._forget_ways(loaded != self._loaded)
        self._loaded = loaded
        here = self._numbers(position + self._pad)
        self._count(position, here)
        self._map[self._robots[:, None], here[:, None] + self._offsets(self.view_radius)] = (
            np.where(arrays["local_grid"] == CELL_CODES[WALL], BLOCKED, FREE)
        )
        goal = np.where(loaded[:, None], arrays["dropoff_pos"], arrays["pickup_pos"]) - position
        return self._view(here, goal)

    def _forget_ways(self, robots: Flags) -> None:
        for array in (self._visits, self._exits, self._came):
            array[robots] = 0

    def _count(self, position: Integers, here: Integers) -> None:
        """Count the visits to where robots are, and the moves that led there."""
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
        """Return the differences of the numbers of cells in a window and of its middle."""
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
        """Double the rows and columns of the maps."""
        side = self._side
        rows, columns = np.divmod(np.arange(side * side), side)
        kept = self._map, self._visits, self._exits
        self._allocate(2 * side)
        places = rows * self._side + columns
        self._map[:, places], self._visits[:, places], self._exits[:, places] = kept


def _over_least(counts: Integers, is_open: Flags) -> SingleFloats:
    """Return how much greater each count is than the least of those that are open, else 0."""
    least = np.where(is_open, counts, np.iinfo(np.int32).max).min(axis=1, keepdims=True)
    return np.where(is_open, np.minimum(counts - least, MOST), 0).astype(np.float32)


def _logs(counts: Integers) -> SingleFloats:
    return LOGS[np.minimum(counts, len(LOGS) - 1)]
