"""What a robot sees around its cell, which depends on the layout alone."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED, WALL, Cell

MAX_WINDOWS = 500
"""Most windows made one by one; as many take about as long as the table of 100 x 100 cells."""

MAX_TABLE_BYTES = 32_000_000
"""Limit on a table; a layout that needs more has none."""

MAX_CACHED_CHARACTERS = 32_000_000
"""Limit on the windows in the cache."""

_STRING_BYTES = 57
"""Size of an empty string and of a pointer to it."""


class Sight:
    """The windows of a layout, ``K = 2 * radius + 1`` strings of ``K`` tiles each.

    The first windows are made when they are needed, and cached. When the cache is full it is
    replaced by a table: for each column the strings that start there in all rows, so that a window
    is a slice of a list.
    """

    def __init__(self, radius: int) -> None:
        self._radius, self._side = radius, 2 * radius + 1
        self._limit = MAX_CACHED_CHARACTERS // self._side**2
        self._padded: list[str] = []
        self._columns: list[list[str]] = []

    def use(self, layout: Layout) -> None:
        """Change the layout; of a table, only the rows that differ are made again."""
        radius, before = self._radius, self._padded
        margin, beyond = WALL * radius, WALL * (layout.width + 2 * radius)
        self._padded = [
            *[beyond] * radius,
            *[f"{margin}{row}{margin}" for row in layout.rows],
            *[beyond] * radius,
        ]
        self._capacity = min(MAX_WINDOWS, self._limit)
        self._windows: dict[tuple[Cell, bool], list[str]] = {}
        if self._columns:
            self._update(before)

    def window(self, cell: Cell, loaded: bool) -> list[str]:
        """Return the window around ``cell``, the robot in the middle, as a new list."""
        if not self._columns:
            window = self._windows.get((cell, loaded)) or self._cached(cell, loaded)
            return window.copy()
        row, col = cell
        window, radius = self._columns[col][row : row + self._side], self._radius
        window[radius] = _with_robot(window[radius], loaded)
        return window

    def _cached(self, cell: Cell, loaded: bool) -> list[str]:
        """Return a window that is not in the cache, and add it."""
        (row, col), side, radius = cell, self._side, self._radius
        window = [line[col : col + side] for line in self._padded[row : row + side]]
        window[radius] = _with_robot(window[radius], loaded)
        if len(self._windows) >= self._capacity:
            self._make_room()
        self._windows[cell, loaded] = window
        return window

    def _make_room(self) -> None:
        """Replace the cache by a table; if none is allowed, let it grow to its limit first."""
        strings = len(self._padded) * len(self._padded[0])
        if strings * (self._side + _STRING_BYTES) <= MAX_TABLE_BYTES:
            self._columns = _columns(self._padded, self._side)
        elif self._capacity < self._limit:
            self._capacity = self._limit
            return
        self._windows.clear()

    def _update(self, before: list[str]) -> None:
        """Change the rows of the table that differ from those before."""
        if [*map(len, before)] != [*map(len, self._padded)]:
            self._columns = []
            return
        for number, (old, new) in enumerate(zip(before, self._padded, strict=True)):
            if old != new:
                for column, (seen,) in zip(self._columns, _columns([new], self._side), strict=True):
                    column[number] = seen


def _columns(rows: list[str], side: int) -> list[list[str]]:
    """Return for each column the ``side`` characters that start there in each row."""
    characters = np.array(rows)
    size = characters.itemsize // len(rows[0])
    shape, strides = (len(rows[0]) - side + 1, len(rows)), (size, characters.itemsize)
    columns: list[list[str]] = np.ndarray(shape, f"U{side}", characters, strides=strides).tolist()
    return columns


@lru_cache(maxsize=10_000)
def _with_robot(middle: str, loaded: bool) -> str:
    """Return the middle row of a window with the robot in it."""
    radius, robot = len(middle) // 2, ROBOT_LOADED if loaded else ROBOT_EMPTY
    return f"{middle[:radius]}{robot}{middle[radius + 1 :]}"
