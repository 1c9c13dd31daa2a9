"""The layouts of a batch as tables: what each robot stands on, can drive to and sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import Flags, Integers, Rows
from warehouse_core.task.encoding import NOWHERE
from warehouse_core.vector.rules import sides_number, station_numbers
from warehouse_core.vector.sight import VectorSight
from warehouse_core.world.tables import LayoutSet, places_table, sides_table, tiles_table

NO_CELL = -1
"""The cell of a pickup or dropoff that a layout does not have."""


class VectorFloor:
    """The layouts of a batch as tables, and the stations of each row.

    ``rows`` are ``[N]`` rows of the batch and ``cells`` the ``[N]`` cells of their robots, numbered
    within their layouts.

    Args:
        layouts: of the rows.
        radius: cells seen in each direction.
        moving_stations: use the stations of ``put_stations``, one pickup and one dropoff for each
            row, instead of those of the layouts.
    """

    def __init__(self, layouts: LayoutSet, radius: int, *, moving_stations: bool) -> None:
        if moving_stations:
            layouts = layouts.without_stations()
        kinds, rows = layouts.kinds, len(layouts.kind)
        self._base, self._moving = layouts.base, moving_stations
        self._sight = VectorSight(layouts, radius)
        self._places = places_table(kinds)
        self._sides = sides_number(sides_table(kinds))
        self._stations = station_numbers(tiles_table(kinds))
        self._station_cells = np.full((2, rows), NO_CELL, np.intp)
        self._station_places = np.empty((2, rows, 2), np.int32)

    def put_stations(self, rows: Integers, pickups: Integers, dropoffs: Integers) -> None:
        """Set the first pickup and dropoff of some rows, as cells or ``NO_CELL``."""
        for number, cells in enumerate((pickups, dropoffs)):
            self._station_cells[number, rows] = cells
            places = self._places.take(self._base[rows] + cells, axis=0)
            places[cells == NO_CELL] = NOWHERE
            self._station_places[number, rows] = places

    def stations(self, rows: Rows, cells: Integers) -> Integers:
        """Return what the robots stand on, ``[N]`` indices into ``rules.STATION_KINDS``."""
        if not self._moving:
            return self._stations.take(self._base[rows] + cells)
        pickups, dropoffs = self._station_cells[:, rows]
        on: Integers = (cells == pickups) + 2 * (cells == dropoffs)
        return on

    def sides(self, rows: Rows, cells: Integers) -> Integers:
        """Return which neighbouring cells are open, ``[N]`` numbers for ``rules.masks``."""
        return self._sides.take(self._base[rows] + cells)

    def places(self, rows: Rows, cells: Integers) -> NDArray[np.int32]:
        """Return row and column of the robots, ``[N, 2]``."""
        return self._places.take(self._base[rows] + cells, axis=0)

    def station_places(self, rows: Rows) -> NDArray[np.int32]:
        """Return row and column of the first pickups and dropoffs, ``[2, N, 2]``."""
        return self._station_places[:, rows]

    def windows(
        self, rows: Rows, cells: Integers, has_item: Flags, robots: Integers
    ) -> NDArray[np.uint8]:
        """Return the windows of the robots, ``[N, K * K]`` codes."""
        moved = self._station_places[:, rows] if self._moving else ()
        return self._sight.windows(self._base[rows] + cells, has_item, robots, *moved)
