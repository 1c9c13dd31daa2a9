"""The floors that ``B`` robots drive on: what each of them stands on, can drive to and sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import Flags, Integers, Rows
from warehouse_core.task.encoding import NOWHERE
from warehouse_core.vector.rules import sides_number, station_numbers
from warehouse_core.vector.sight import VectorSight
from warehouse_core.world.tables import LayoutSet, places_table, sides_table, tiles_table

NO_CELL = -1
"""Stands for a pickup or dropoff that a layout does not have."""


class VectorFloor:
    """The layouts of a batch as tables, and the stations of each row.

    ``rows`` are ``[N]`` rows of the batch, ``cells`` ``[N]`` the cells of their robots by their
    number in their layout.

    Args:
        layouts: of the rows.
        radius: cells seen in each direction.
        moving_stations: the stations are where ``put_stations`` puts them, one pickup and one
            dropoff a row, and not where the layouts have them.
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
        """Say where the first pickup and dropoff of some rows are, by cell, or ``NO_CELL``."""
        for number, cells in enumerate((pickups, dropoffs)):
            self._station_cells[number, rows] = cells
            places = self._places.take(self._base[rows] + cells, axis=0)
            places[cells == NO_CELL] = NOWHERE
            self._station_places[number, rows] = places

    def stations(self, rows: Rows, cells: Integers) -> Integers:
        """Return what the robots stand on, ``[N]`` indices into ``batch_rules.STATION_KINDS``."""
        if not self._moving:
            return self._stations.take(self._base[rows] + cells)
        pickups, dropoffs = self._station_cells[:, rows]
        on: Integers = (cells == pickups) + 2 * (cells == dropoffs)
        return on

    def sides(self, rows: Rows, cells: Integers) -> Integers:
        """Return which neighbouring cells are open, ``[N]`` numbers for ``batch_rules.masks``."""
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
        """Return what the robots at these places see, ``[N, K * K]`` codes."""
        moved = self._station_places[:, rows] if self._moving else ()
        return self._sight.windows(self._base[rows] + cells, has_item, robots, *moved)
