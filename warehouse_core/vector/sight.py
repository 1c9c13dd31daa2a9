"""What ``B`` robots see: a window of the walls from a table, and the stations on top.

A station is at a place of the window that follows from how far it is from the robot. Counted row by
row on a grid that is wide enough, that distance is one number, and the place is looked up by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import Flags, Integers
from warehouse_core.world.tables import LayoutSet, windows_table
from warehouse_core.world.tiles import CELL_CODES, DROPOFF, PICKUP, ROBOT_EMPTY, ROBOT_LOADED


class VectorSight:
    """The windows of a set of layouts, ``[B, K * K]`` codes.

    Args:
        layouts: of the batch.
        radius: cells seen in each direction.
    """

    def __init__(self, layouts: LayoutSet, radius: int) -> None:
        self._radius = radius
        self._table = windows_table(layouts.kinds, radius)
        self._cells = self._table.shape[1]
        self._centre = self._cells // 2
        # Wide enough that a station beyond one edge is not taken for one beyond the other.
        self._stride = max(layout.width for layout in layouts.kinds) + radius
        self._reach = radius * self._stride + radius + 1
        self._place_of = self._places()

    def windows(
        self, cells: Integers, has_item: Flags, robots: Integers, *stations: Integers
    ) -> NDArray[np.uint8]:
        """Return what is seen, fresh.

        Args:
            cells: ``[N]``, the robots' cells by their number in the tables.
            has_item: ``[N]``, whether they are loaded.
            robots: ``[N, 2]``, row and column of the robots.
            *stations: ``[N, 2]`` of the pickups and of the dropoffs that are not in the tables;
                there must be one for each robot.
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
        """Write a code where the stations are; those out of sight go where the robot will."""
        way = stations - robots
        # Long ways on a wide grid come to more than 32 bits hold.
        distance = np.multiply(way[:, 0], self._stride, dtype=np.intp)
        distance += way[:, 1] + self._reach
        place = self._place_of.take(distance, mode="clip")
        place += np.arange(0, windows.size, self._cells)
        windows.reshape(-1)[place] = code

    def _places(self) -> NDArray[np.intp]:
        """Return the place in the window for each distance, the middle for those out of sight."""
        places = np.full(2 * self._reach + 1, self._centre)
        side = np.arange(-self._radius, self._radius + 1)
        distances = side[:, None] * self._stride + side + self._reach
        places[distances.ravel()] = np.arange(self._cells)
        return places
