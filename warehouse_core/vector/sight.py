"""What ``B`` robots see: windows of the walls from a table, with the stations added.

The place of a station in the window depends on its offset from the robot. On a grid that is wide
enough, this offset is a single number, row by row, and the place is looked up in a table.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import Flags, Integers
from warehouse_core.world.tables import LayoutSet, windows_table
from warehouse_core.world.tiles import CELL_CODES, DROPOFF, PICKUP, ROBOT_EMPTY, ROBOT_LOADED


class VectorSight:
    """The windows of a set of layouts.

    Args:
        layouts: of the batch.
        radius: cells seen in each direction.
    """

    def __init__(self, layouts: LayoutSet, radius: int) -> None:
        self._radius = radius
        self._table = windows_table(layouts.kinds, radius)
        self._cells = self._table.shape[1]
        self._centre = self._cells // 2
        # Wide enough that a station beyond one edge does not appear at the other.
        self._stride = max(layout.width for layout in layouts.kinds) + radius
        self._reach = radius * self._stride + radius + 1
        self._place_of = self._places()

    def windows(
        self, cells: Integers, has_item: Flags, robots: Integers, *stations: Integers
    ) -> NDArray[np.uint8]:
        """Return fresh windows, ``[N, K * K]`` codes.

        Args:
            cells: ``[N]`` cells of the robots, numbered as in the tables.
            has_item: ``[N]``, whether they are loaded.
            robots: ``[N, 2]``, row and column of the robots.
            *stations: ``[N, 2]`` each, the pickups and the dropoffs if not in the tables.
        """
        windows = self._table.take(cells, axis=0)
        if self._radius:
            for tile, places in zip((PICKUP, DROPOFF), stations, strict=False):
                self._mark(windows, CELL_CODES[tile], places, robots)
        windows[:, self._centre] = np.where(
            has_item, CELL_CODES[ROBOT_LOADED], CELL_CODES[ROBOT_EMPTY]
        )
        return windows

    def _mark(
        self, windows: NDArray[np.uint8], code: int, stations: Integers, robots: Integers
    ) -> None:
        """Write a code where the stations are; those out of sight go to the middle."""
        way = stations - robots
        # Distances on a large grid can exceed 32 bits.
        distance = np.multiply(way[:, 0], self._stride, dtype=np.intp)
        distance += way[:, 1] + self._reach
        place = self._place_of.take(distance, mode="clip")
        place += np.arange(0, windows.size, self._cells)
        windows.reshape(-1)[place] = code

    def _places(self) -> NDArray[np.intp]:
        """Return the place in the window for each distance, the middle if out of sight."""
        places = np.full(2 * self._reach + 1, self._centre)
        side = np.arange(-self._radius, self._radius + 1)
        distances = side[:, None] * self._stride + side + self._reach
        places[distances.ravel()] = np.arange(self._cells)
        return places
