"""The layouts of a batch as tables of stations, open sides and windows."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet_settings import FleetSettings
from warehouse_core.batch.kernels import Ground, Views
from warehouse_core.batch.verdicts import STATION_NUMBERS, masks, sides_number, station_numbers
from warehouse_core.errors import LayoutError
from warehouse_core.task.encoding import NOWHERE, Window, marks
from warehouse_core.world.distances import nearest
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
from warehouse_core.world.tiles import (
    CELL_CODES,
    CHARGER,
    DROPOFF,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
)

ALL = slice(None)
"""All rows."""

NO_CELL = -1
"""Number of the cell of a pickup or dropoff that does not exist."""

OUT_OF_SIGHT = int(np.iinfo(np.intp).min) // 2
"""Offset of a station that does not exist."""

_ROBOT_CODES = np.array([CELL_CODES[ROBOT_EMPTY], CELL_CODES[ROBOT_LOADED]], np.uint8)
"""Codes of robots without and with an item."""


class BatchFloor:
    """The layouts of a batch as tables, and the stations of each row.

    The arguments of methods are ``rows``, ``[N]`` rows of the batch, and ``cells``, the ``[N]``
    cells of their robots, numbered within their layouts. Methods without ``rows`` need the cells of
    all ``B`` rows.

    Args:
        layouts: layouts of the rows.
        radius: cells seen in each direction.
        moving_stations: ``True`` for one pickup and one dropoff per row, set with
            ``put_stations``, in layouts without stations.
        tiles: tiles for which windows have ``encoding.marks``. They must include pickup and
            dropoff, and no robot. Without them, or if the marks would take more than
            ``MAX_TABLE_BYTES``, windows have codes.

    Attributes:
        station_places: ``[2, B, 2]``, row and column of the first pickup and the first dropoff of
            each row.
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
        # The place of a station in the window depends on its offset from the robot. The offset is
        # one number, for rows so wide that stations beyond one edge do not appear at the other.
        self._stride = max(layout.width for layout in kinds) + radius + 1
        self._reach = radius * self._stride + radius + 1
        self._offset_of = self._places @ np.array([self._stride, 1], np.intp)
        self._station_offsets = np.full((2, rows), OUT_OF_SIGHT, np.intp)
        self._cached_cells: Integers | None = None
        # Offsets out of sight lead to the middle of the window, where the robot is.
        places = np.arange(0, self._windows.shape[1], self._marks)
        self._centre = places[len(places) // 2]
        self._place_of = np.full(2 * self._reach + 1, self._centre)
        # First mark of the tile, and value to write there, for pickups and dropoffs.
        stations = (PICKUP, DROPOFF)
        firsts = [tiles.index(tile) if tiles else 0 for tile in stations]
        values = [1 if tiles else CELL_CODES[tile] for tile in stations]
        self._first_marks, self._mark_values = np.array([firsts, values])[..., None]
        side = np.arange(-radius, radius + 1)
        offsets = side[:, None] * self._stride + side + self._reach
        self._place_of[offsets.ravel()] = places

    def put_stations(self, rows: Integers, cells: Integers) -> None:
        """Set the first pickup and dropoff of some rows, ``[2, N]`` cells or ``NO_CELL``."""
        self._cached_cells = None
        numbers, is_missing = self._numbers(rows, cells), cells == NO_CELL
        places, offsets = self._places.take(numbers, axis=0), self._offset_of.take(numbers)
        places[is_missing] = NOWHERE
        self._station_cells[:, rows], self.station_places[:, rows] = cells, places
        self._station_offsets[:, rows] = np.where(is_missing, OUT_OF_SIGHT, offsets + self._reach)

    def put_own_stations(self, rows: Integers) -> None:
        """Set the pickup and dropoff of some rows to the first ones of their layouts."""
        self.put_stations(rows, self._first_stations[:, self._layouts.kind[rows]])

    def stations(self, cells: Integers) -> Integers:
        """Return the kinds of the robots' cells, ``[B]`` indices into ``verdicts.STATION_KINDS``.

        The result is cached for the same array, because the masks after a step need it again.
        Neither array may be changed.
        """
        if cells is not self._cached_cells:
            self._cached_cells, self._cached_stations = cells, self._stations_at(cells)
        return self._cached_stations

    def _stations_at(self, cells: Integers) -> Integers:
        if not self.moving_stations:
            return self._stations.take(self._numbers(ALL, cells))
        on = self._stations_of_rows(cells)
        if self.has_chargers:  # these layouts have nothing else, and no charger below a station
            on += self._stations.take(self._numbers(ALL, cells))
        return on

    def _stations_of_rows(self, cells: Integers) -> Integers:
        """Return the kinds of the robots' cells, considering only ``put_stations``."""
        pickups, dropoffs = self._station_cells
        on: Integers = (cells == pickups) + 2 * (cells == dropoffs)
        return on

    def _numbers(self, rows: Rows, cells: Integers) -> Integers:
        """Return the indices of cells in the tables."""
        return cells if self._is_uniform else self._base[rows] + cells

    def masks(self, cells: Integers, has_item: Flags) -> NDArray[np.int8]:
        """Return the masks of actions with an effect, ``[B, 7]``; see ``verdicts.masks``."""
        sides = self._sides.take(self._numbers(ALL, cells))
        return masks(sides, self.stations(cells), has_item)

    def places(self, rows: Rows, cells: Integers) -> NDArray[np.int32]:
        """Return the rows and columns of cells, ``[N, 2]``."""
        return self._places.take(self._numbers(rows, cells), axis=0)

    def windows(self, rows: Rows, cells: Integers, has_item: Flags) -> Window:
        """Return new windows, ``[N, K * K]`` codes or ``[N, K * K * T]`` marks."""
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
            # Write the tiles of stations. Those out of sight are written to the middle.
            offsets = self._station_offsets[:, rows] - self._offset_of.take(numbers)
            places = self._place_of.take(offsets, mode="clip")
            places += self._first_marks + np.arange(0, windows.size, windows.shape[1])
            windows.reshape(-1)[places] = self._mark_values
        return windows


def _first_stations(layout: Layout) -> list[int]:
    """Return the first pickup and dropoff of a layout, as cells or ``NO_CELL``."""
    stations = layout.pickups[:1], layout.dropoffs[:1]
    return [layout.number(cells[0]) if cells else NO_CELL for cells in stations]


NOTHING = 0
"""Code of a spot with nothing on top of the tile, which is also the code of an empty cell."""

_WAITING = np.uint8(CELL_CODES[PICKUP])

_OTHER_CODES = np.array([CELL_CODES[OTHER_EMPTY], CELL_CODES[OTHER_LOADED]], np.uint8)
"""Codes of other robots without and with an item."""


_STATION_CODES = np.array([CELL_CODES[PICKUP], CELL_CODES[DROPOFF]], np.uint8)


class FleetFloor(BatchFloor):
    """A ``BatchFloor`` for ``B`` floors with ``R`` robots on each.

    One array has everything on top of the tiles. It contains the floors end to end, each with a
    margin of ``radius`` cells. A *spot* is an index into this array. Chargers and open orders are
    on the ground, below robots and people. With orders, the orders determine the stations;
    otherwise stations are tiles of the layouts.

    Attributes:
        for_kernels: tables and stations for the kernels of fleets.
        views: tables of windows, and what is on top of the tiles, for the same kernels.
    """

    def __init__(self, layouts: LayoutSet, settings: FleetSettings) -> None:
        robots, radius, has_orders = settings.robots, settings.view_radius, settings.has_orders
        _check_windows(len(layouts.kind) * robots, 2 * radius + 1)
        repeated = [layout for layout in layouts.rows for _ in range(robots)]
        super().__init__(LayoutSet(repeated, bare=has_orders), radius, moving_stations=has_orders)
        # Around a single robot without orders, nothing is on top of the tiles.
        self._is_bare = settings.bodies == 1 and not has_orders
        kinds = layouts.kinds
        strides = [kind.width + 2 * radius for kind in kinds]
        sizes = [(kind.height + 2 * radius) * (kind.width + 2 * radius) for kind in kinds]
        ends = np.cumsum(layouts.of_rows(sizes))
        self._corner = np.concatenate([[0], ends[:-1]])
        self._corner_of = np.repeat(self._corner, robots)
        self._floor_base = layouts.base
        self._spots = np.concatenate(
            [
                places_table([kind]) @ [stride, 1] + radius * (stride + 1)
                for kind, stride in zip(kinds, strides, strict=True)
            ]
        ).astype(np.int32)  # half the size of intp, and faster random access
        side = np.arange(-radius, radius + 1)
        self._offsets = np.array([(side[:, None] * stride + side).ravel() for stride in strides])
        self._kind = np.repeat(layouts.kind, robots)
        self._chargers = np.concatenate([_nearest_chargers(kind) for kind in kinds])
        self._ground = np.full(ends[-1], NOTHING, np.uint8)
        for corner, base, layout in zip(self._corner, layouts.base, layouts.rows, strict=True):
            chargers = self._spots.take(base + layout.numbers(layout.chargers))
            self._ground[corner + chargers] = CELL_CODES[CHARGER]
        self._on_top = self._ground.copy()
        self._covered = self._robot_spots = self._corner_of[:0]
        # Kernels get no views of arrays, because a copy of a view does not change with its array.
        self.for_kernels = Ground(
            self._base, self._corner_of, self._spots, self._stations, STATION_NUMBERS, self._sides,
            self._ground, self._station_cells, np.zeros(len(self._kind), np.int16), has_orders,
        )  # fmt: skip
        windows = cast(NDArray[np.uint8], self._windows)  # these floors have no marks
        self.views = Views(
            radius, windows, self._places, self._chargers, np.array(strides).take(self._kind),
            self._on_top, np.zeros(len(layouts.kind) * settings.bodies, np.intp),
            self.station_places, _ROBOT_CODES, _OTHER_CODES, _STATION_CODES,
            CELL_CODES[PERSON], self._is_bare, self._floor_base, self._corner,
        )  # fmt: skip

    def set_waiting(
        self, floors: Integers | int, cells: Integers, is_waiting: Integers | bool
    ) -> None:
        """Set whether open orders wait at the cells ``[N]`` of floors."""
        self._cached_cells = None
        spots = self._corner[floors] + self._spots[self._floor_base[floors] + cells]
        self._ground[spots] = self._on_top[spots] = np.where(is_waiting, _WAITING, NOTHING)

    def _stations_at(self, cells: Integers) -> Integers:
        if not self.moving_stations:
            return super()._stations_at(cells)
        on_ground = station_numbers(self._ground.take(self._spots_of(cells)))
        return self._stations_of_rows(cells) | on_ground

    def show(self, cells: Integers, has_item: Flags, people: Integers) -> None:
        """Show robots ``[B * R]`` and people ``[B, P]`` in their cells."""
        if self._is_bare:
            return
        self._on_top[self._covered] = self._ground.take(self._covered)
        self._covered = self._robot_spots = self._spots_of(cells)
        self._on_top[self._covered] = _OTHER_CODES.take(has_item)
        if people.size:
            persons = self._corner[:, None] + self._spots.take(self._floor_base[:, None] + people)
            self._covered = np.concatenate([self._robot_spots, persons.ravel()])
            self._on_top[persons] = CELL_CODES[PERSON]

    def nearest_chargers(self, rows: Rows, cells: Integers) -> NDArray[np.int32]:
        """Return the row and column of each cell's nearest charger, or ``NOWHERE``, ``[N, 2]``."""
        return self._chargers.take(self._numbers(rows, cells), axis=0)

    def _spots_of(self, cells: Integers) -> Integers:
        spots: Integers = self._spots.take(self._numbers(ALL, cells))
        return spots.astype(np.intp) if len(self._corner) == 1 else self._corner_of + spots

    def _around(self, rows: Rows, cells: Integers) -> Window:
        windows = super()._around(rows, cells)
        if self._is_bare:
            return windows
        spots = self._robot_spots[rows]
        offsets = self._offsets
        if len(offsets) > 1:
            offsets = offsets.take(self._kind[rows], axis=0)
        around = self._on_top.take(spots[:, None] + offsets)
        np.maximum(windows, around, out=windows)
        return windows


def _check_windows(robots: int, side: int) -> None:
    """Raise ``LayoutError`` if the spots of all windows take more than ``MAX_TABLE_BYTES``."""
    needed = robots * side**2 * np.dtype(np.intp).itemsize
    if needed > MAX_TABLE_BYTES:
        raise LayoutError(
            f"windows of {side} x {side} around {robots} robots take {needed} bytes; "
            f"MAX_TABLE_BYTES = {MAX_TABLE_BYTES} are allowed"
        )


def _nearest_chargers(layout: Layout) -> NDArray[np.int32]:
    """Return the row and column of every cell's nearest charger, ``[H * W, 2]``."""
    cells = nearest(layout, layout.chargers).ravel()
    places = layout.places(cells).astype(np.int32)
    places[cells < 0] = NOWHERE
    return places
