"""What a robot sees around its cell.

It depends on the layout alone, so each window is cached.
"""

from __future__ import annotations

from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED, WALL, Cell

_MAX_CACHED_CHARACTERS = 32_000_000


class Sight:
    """The windows of one layout, ``K = 2 * radius + 1`` strings of ``K`` tiles each."""

    def __init__(self, layout: Layout, radius: int) -> None:
        self._radius, self._side = radius, 2 * radius + 1
        margin, beyond = WALL * radius, WALL * (layout.width + 2 * radius)
        self._padded = [
            *[beyond] * radius,
            *[f"{margin}{row}{margin}" for row in layout.rows],
            *[beyond] * radius,
        ]
        self._windows: dict[tuple[Cell, bool], list[str]] = {}
        self._capacity = max(1, _MAX_CACHED_CHARACTERS // self._side**2)

    def window(self, cell: Cell, loaded: bool) -> list[str]:
        """Return the window around ``cell``, the robot in the middle, as a new list."""
        window = self._windows.get((cell, loaded))
        if window is None:
            (row, col), side, radius = cell, self._side, self._radius
            window = [line[col : col + side] for line in self._padded[row : row + side]]
            middle, robot = window[radius], ROBOT_LOADED if loaded else ROBOT_EMPTY
            window[radius] = f"{middle[:radius]}{robot}{middle[radius + 1 :]}"
            if len(self._windows) >= self._capacity:
                self._windows.clear()
            self._windows[cell, loaded] = window
        return window.copy()
