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

ALL = slice(None)
"""All rows."""

NO_CELL = -1
"""The cell of a pickup or dropoff that a layout does not have."""

OUT_OF_SIGHT = int(np.iinfo(np.intp).min) // 2
"""Offset of a station that does not exist."""

_ROBOT_CODES = np.array([CELL_CODES[ROBOT_EMPTY], CELL_CODES[ROBOT_LOADED]], np.uint8)
"""Codes of robots without and with an item."""


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
        self._marks, self._tiles = len(tiles) or 1, tiles
        windows = windows_table(kinds, radius)
        self._windows = marks(windows, tiles) if tiles else windows
        self._places = places_table(kinds)
        self._sides = sides_number(sides_table(kinds))
        self._stations = station_numbers(tiles_table(kinds))
        self._is_uniform = len(kinds) == 1
        self._station_cells = np.full((2, rows), NO_CELL, np.intp)
        self.station_places = np.empty((2, rows, 2), np.int32)
        # The place of a station in the window depends on its offset from the robot, which is one
        # number in rows so wide that a station beyond one edge does not appear at the other.
        self._stride = max(layout.width for layout in kinds) + radius + 1
        self._reach = radius * self._stride + radius + 1
        self._offset_of = self._places @ np.array([self._stride, 1], np.intp)
        self._station_offsets = np.full((2, rows), OUT_OF_SIGHT, np.intp)
        self._asked: Integers | None = None
        # The place for each offset is the middle, where the robot is, if it is out of sight.
        places = np.arange(0, self._windows.shape[1], self._marks)
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
        self._asked = None
        for number, cells in enumerate((pickups, dropoffs)):
            self._station_cells[number, rows] = cells
            places = self.places(rows, cells)
            places[cells == NO_CELL] = NOWHERE
            self.station_places[number, rows] = places
            offsets = self._offset_of.take(self._numbers(rows, cells)) + self._reach
            self._station_offsets[number, rows] = np.where(cells == NO_CELL, OUT_OF_SIGHT, offsets)

    def put_own_stations(self, rows: Integers) -> None:
        """Set the first pickup and dropoff of some rows as in their layouts."""
        self.put_stations(rows, *self._first_stations[:, self._layouts.kind[rows]])

    def stations(self, cells: Integers) -> Integers:
        """Return what the robots stand on, ``[B]`` indices into ``verdicts.STATION_KINDS``.

        The answer is kept for the same array, as the masks after a step ask for it again; neither
        array may be changed.
        """
        if cells is not self._asked:
            self._asked, self._stood_on = cells, self._stations_at(cells)
        return self._stood_on

    def _stations_at(self, cells: Integers) -> Integers:
        if not self.moving_stations:
            return self._stations.take(self._numbers(ALL, cells))
        on = self._stations_of_rows(cells)
        if self.has_chargers:  # all that is left in these layouts, and never below a station
            on += self._stations.take(self._numbers(ALL, cells))
        return on

    def _stations_of_rows(self, cells: Integers) -> Integers:
        """Return what the robots stand on of the stations of ``put_stations``."""
        pickups, dropoffs = self._station_cells
        on: Integers = (cells == pickups) + 2 * (cells == dropoffs)
        return on

    def _numbers(self, rows: Rows, cells: Integers) -> Integers:
        """Return the numbers of cells in the tables."""
        return cells if self._is_uniform else self._base[rows] + cells

    def masks(self, cells: Integers, has_item: Flags) -> NDArray[np.int8]:
        """Return the masks of actions that do something, ``[B, 7]``; see ``verdicts.masks``."""
        sides = self._sides.take(self._numbers(ALL, cells))
        return masks(sides, self.stations(cells), has_item)

    def places(self, rows: Rows, cells: Integers) -> NDArray[np.int32]:
        """Return row and column of the cells, ``[N, 2]``."""
        return self._places.take(self._numbers(rows, cells), axis=0)

    def windows(self, rows: Rows, cells: Integers, has_item: Flags) -> Window:
        """Return fresh windows, ``[N, K * K]`` codes or ``[N, K * K * T]`` marks."""
        windows = self._around(rows, cells)
        if self._tiles:
            windows[:, self._centre : self._centre + self._marks] = False
        else:
            windows[:, self._centre] = _ROBOT_CODES.take(has_item)
        return windows

    def _around(self, rows: Rows, cells: Integers) -> Window:
        """Return the windows without the robots in their middle."""
        numbers = self._numbers(rows, cells)
        windows = self._windows.take(numbers, axis=0)
        if self.moving_stations and self._radius:
            # Write tiles where the stations are; those out of sight go to the middle.
            offsets = self._station_offsets[:, rows] - self._offset_of.take(numbers)
            places = self._place_of.take(offsets, mode="clip")
            places += self._first_marks + np.arange(0, windows.size, windows.shape[1])
            windows.reshape(-1)[places] = self._mark_values
        return windows


def _first_stations(layout: Layout) -> list[int]:
    """Return the first pickup and dropoff of a layout, as cells or ``NO_CELL``."""
    stations = layout.pickups[:1], layout.dropoffs[:1]
    return [layout.number(cells[0]) if cells else NO_CELL for cells in stations]
