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
        self._side = 2 * radius + 1
        margin, beyond = WALL * radius, WALL * (layout.width + 2 * radius)
        self._padded = [
            *[beyond] * radius,
            *[f"{margin}{row}{margin}" for row in layout.rows],
            *[beyond] * radius,
        ]
        self._centre = radius
        self._windows: dict[tuple[Cell, bool], list[str]] = {}
        self._capacity = max(1, _MAX_CACHED_CHARACTERS // self._side**2)

    def window(self, cell: Cell, loaded: bool) -> list[str]:
        """Return the window around ``cell``, the robot in the middle, as a new list."""
        known = self._windows.get((cell, loaded))
        if known is None:
            known = self._cut(cell, loaded)
        return known.copy()

    def _cut(self, cell: Cell, loaded: bool) -> list[str]:
        row, col = cell
        window = [line[col : col + self._side] for line in self._padded[row : row + self._side]]
        middle, centre = window[self._centre], self._centre
        robot = ROBOT_LOADED if loaded else ROBOT_EMPTY
        window[centre] = f"{middle[:centre]}{robot}{middle[centre + 1 :]}"
        if len(self._windows) >= self._capacity:
            self._windows.clear()
        self._windows[cell, loaded] = window
        return window
