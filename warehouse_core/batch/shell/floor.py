"""The layouts of a batch as tables: what each robot stands on, can drive to and sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.shell.verdicts import masks, sides_number, station_numbers
from warehouse_core.task.encoding import NOWHERE, Window, marks
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import (
    MAX_TABLE_BYTES,
    Flags,
    Integers,
    LayoutSet,
    Rows,
    places_table,
    sides_table,
    tiles_table,
    windows_bytes,
    windows_table,
)
from warehouse_core.world.tiles import CELL_CODES, DROPOFF, PICKUP, ROBOT_EMPTY, ROBOT_LOADED

NO_CELL = -1
"""The cell of a pickup or dropoff that a layout does not have."""


class Floor:
    """The layouts of a batch as tables, and the stations of each row.

    Methods take ``rows``, ``[N]`` rows of the batch, and ``cells``, the ``[N]`` cells of their
    robots, numbered within their layouts. A method without ``rows`` takes the cells of all ``B``.

    Args:
        layouts: layouts of the rows.
        radius: cells seen in each direction.
        moving_stations: use the stations of ``put_stations``, one pickup and one dropoff for each
            row; the layouts have none of their own.
        tiles: tiles whose ``encoding.marks`` the windows are, with pickup and dropoff but no robot
            among them; by default, or if the marks would take more than ``MAX_TABLE_BYTES``,
            windows are codes.

    Attributes:
        station_places: ``[2, B, 2]``, row and column of the first pickups and dropoffs.
    """

    def __init__(
        self, layouts: LayoutSet, radius: int, *, moving_stations: bool, tiles: tuple[str, ...] = ()
    ) -> None:
        kinds, rows = layouts.kinds, len(layouts.kind)
        self._layouts, self._first_stations = layouts, np.array([*map(_first_stations, kinds)]).T
        self._base, self.moving_stations, self._radius = layouts.base, moving_stations, radius
        self.has_chargers = any(kind.chargers for kind in kinds)
        if len(tiles) * windows_bytes(kinds, radius) > MAX_TABLE_BYTES:
            tiles = ()
        self._numbers, self._tiles = len(tiles) or 1, tiles
        windows = windows_table(kinds, radius)
        self._windows = marks(windows, tiles) if tiles else windows
        self._places = places_table(kinds)
        self._sides = sides_number(sides_table(kinds))
        self._stations = station_numbers(tiles_table(kinds))
        self._station_cells = np.full((2, rows), NO_CELL, np.intp)
        self.station_places = np.empty((2, rows, 2), np.int32)
        # The place of a station in the window depends on its offset from the robot, which is one
        # number in rows so wide that a station beyond one edge does not appear at the other.
        self._stride = max(layout.width for layout in kinds) + radius + 1
        self._reach = radius * self._stride + radius + 1
        # The place for each offset is the middle, where the robot is, if it is out of sight.
        places = np.arange(0, self._windows.shape[1], self._numbers)
        self._centre = places[len(places) // 2]
        self._place_of = np.full(2 * self._reach + 1, self._centre)
        # For pickups and dropoffs: where their tile's marks begin, and what is written there.
        stations = (PICKUP, DROPOFF)
        firsts = [tiles.index(tile) if tiles else 0 for tile in stations]
        values = [1 if tiles else CELL_CODES[tile] for tile in stations]
        self._first_marks, self._mark_values = np.array([firsts, values])[..., None]
        side = np.arange(-radius, radius + 1)
        offsets = side[:, None] * self._stride + side + self._reach
        self._place_of[offsets.ravel()] = places

    def put_stations(self, rows: Integers, pickups: Integers, dropoffs: Integers) -> None:
        """Set the first pickup and dropoff of some rows, as cells or ``NO_CELL``."""
        for number, cells in enumerate((pickups, dropoffs)):
            self._station_cells[number, rows] = cells
            places = self.places(rows, cells)
            places[cells == NO_CELL] = NOWHERE
            self.station_places[number, rows] = places

    def put_own_stations(self, rows: Integers) -> None:
        """Set the first pickup and dropoff of some rows as in their layouts."""
        self.put_stations(rows, *self._first_stations[:, self._layouts.kind[rows]])

    def stations(self, cells: Integers) -> Integers:
        """Return what the robots stand on, ``[B]`` indices into ``verdicts.STATION_KINDS``."""
        if not self.moving_stations:
            return self._stations.take(self._base + cells)
        pickups, dropoffs = self._station_cells
        on: Integers = (cells == pickups) + 2 * (cells == dropoffs)
        if self.has_chargers:  # all that is left in these layouts, and never below a station
            on += self._stations.take(self._base + cells)
        return on

    def masks(self, cells: Integers, has_item: Flags) -> NDArray[np.int8]:
        """Return the masks of actions that do something, ``[B, 7]``; see ``verdicts.masks``."""
        return masks(self._sides.take(self._base + cells), self.stations(cells), has_item)

    def places(self, rows: Rows, cells: Integers) -> NDArray[np.int32]:
        """Return row and column of the cells, ``[N, 2]``."""
        return self._places.take(self._base[rows] + cells, axis=0)

    def windows(self, rows: Rows, cells: Integers, has_item: Flags, robots: Integers) -> Window:
        """Return fresh windows, ``[N, K * K]`` codes or ``[N, K * K * T]`` marks.

        ``robots`` are the rows and columns of the cells.
        """
        windows = self._around(rows, cells, robots)
        if self._tiles:
            windows[:, self._centre : self._centre + self._numbers] = False
        else:
            windows[:, self._centre] = np.where(
                has_item, CELL_CODES[ROBOT_LOADED], CELL_CODES[ROBOT_EMPTY]
            )
        return windows

    def _around(self, rows: Rows, cells: Integers, robots: Integers) -> Window:
        """Return the windows without the robots in their middle."""
        windows = self._windows.take(self._base[rows] + cells, axis=0)
        if self.moving_stations and self._radius:
            self._mark(windows, self.station_places[:, rows], robots)
        return windows

    def _mark(self, windows: Window, stations: Integers, robots: Integers) -> None:
        """Write tiles where the stations are; those out of sight go to the middle."""
        way = stations - robots
        # Offsets on a large grid can exceed 32 bits.
        offset = np.multiply(way[..., 0], self._stride, dtype=np.intp)
        offset += way[..., 1]
        offset += self._reach
        offset[stations[..., 0] < 0] = 0  # without a station: NOWHERE is next to a corner
        place = self._place_of.take(offset, mode="clip")
        place += self._first_marks
        place += np.arange(0, windows.size, windows.shape[1])
        windows.reshape(-1)[place] = self._mark_values


def _first_stations(layout: Layout) -> list[int]:
    """Return the first pickup and dropoff of a layout, as cells or ``NO_CELL``."""
    stations = layout.pickups[:1], layout.dropoffs[:1]
    return [layout.number(cells[0]) if cells else NO_CELL for cells in stations]
