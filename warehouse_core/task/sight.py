"""The view of a robot around its cell, which depends only on the layout."""

from __future__ import annotations

from functools import lru_cache

from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED, WALL, Cell

MAX_CACHED_WINDOWS, MAX_CACHED_CHARACTERS = 20_000, 32_000_000
"""Limits on the cached windows and on their characters. A full cache is cleared. A window of 5 x 5
cells takes half a kilobyte, so the cache takes about 10 MB; a map of 100 x 100 cells fits."""


class Sight:
    """A cache of a layout's windows, each ``K = 2 * radius + 1`` strings of ``K`` tiles."""

    def __init__(self, radius: int) -> None:
        self._radius, self._side = radius, 2 * radius + 1
        self._capacity = min(MAX_CACHED_WINDOWS, MAX_CACHED_CHARACTERS // self._side**2)

    def use(self, layout: Layout) -> None:
        """Change the layout."""
        radius = self._radius
        margin, beyond = WALL * radius, WALL * (layout.width + 2 * radius)
        self._padded = [
            *[beyond] * radius,
            *[f"{margin}{row}{margin}" for row in layout.rows],
            *[beyond] * radius,
        ]
        self._windows: dict[tuple[Cell, bool], list[str]] = {}

    def window(self, cell: Cell, loaded: bool) -> list[str]:
        """Return the window around ``cell``, with the robot in the middle, as a new list."""
        window = self._windows.get((cell, loaded)) or self._cached(cell, loaded)
        return window.copy()

    def _cached(self, cell: Cell, loaded: bool) -> list[str]:
        """Return a window that is not in the cache yet, and add it to the cache."""
        (row, col), side, radius = cell, self._side, self._radius
        window = [line[col : col + side] for line in self._padded[row : row + side]]
        window[radius] = _with_robot(window[radius], loaded)
        if len(self._windows) >= self._capacity:
            self._windows.clear()
        self._windows[cell, loaded] = window
        return window


@lru_cache(maxsize=10_000)
def _with_robot(middle: str, loaded: bool) -> str:
    """Return the middle row of a window with the robot in it."""
    radius, robot = len(middle) // 2, ROBOT_LOADED if loaded else ROBOT_EMPTY
    return f"{middle[:radius]}{robot}{middle[radius + 1 :]}"
