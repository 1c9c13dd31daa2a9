"""The floors of fleets: where open orders wait, and the others that a robot sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.fleet.settings import FleetSettings
from warehouse_core.batch.shell.floor import ALL, Floor
from warehouse_core.batch.shell.verdicts import station_numbers
from warehouse_core.errors import LayoutError
from warehouse_core.task.encoding import NOWHERE, Window
from warehouse_core.world.distances import nearest
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import (
    MAX_TABLE_BYTES,
    Flags,
    Integers,
    LayoutSet,
    Rows,
    places_table,
)
from warehouse_core.world.tiles import (
    CELL_CODES,
    CHARGER,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    PICKUP,
)

NOTHING = 0
"""Code of a tile with nothing on top; an empty cell has the same code."""

_OTHER_CODES = np.array([CELL_CODES[OTHER_EMPTY], CELL_CODES[OTHER_LOADED]], np.uint8)
"""Codes of other robots without and with an item."""


class FleetFloor(Floor):
    """A ``Floor`` for ``B`` floors with ``R`` robots on each.

    What is on top of the tiles stands in one array, in which the floors lie end to end, each with
    a margin of ``radius`` cells. A *spot* is an index in it. On the ground, below robots and
    people, are chargers and open orders. With orders, stations are where orders have them;
    otherwise they are the tiles of the layouts.
    """

    def __init__(self, layouts: LayoutSet, settings: FleetSettings) -> None:
        robots, radius, has_orders = settings.robots, settings.view_radius, settings.has_orders
        _check_windows(len(layouts.kind) * robots, 2 * radius + 1)
        repeated = [layout for layout in layouts.rows for _ in range(robots)]
        super().__init__(LayoutSet(repeated, bare=has_orders), radius, moving_stations=has_orders)
        # Nothing lies on the tiles around a robot that is alone.
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
        ).astype(np.int32)  # half the size of intp, and faster to read at random
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

    def set_waiting(self, floor: int, cell: int, is_waiting: bool) -> None:
        """Set whether an open order waits at a cell of a floor."""
        self._asked = None
        spot = self._corner[floor] + self._spots[self._floor_base[floor] + cell]
        self._ground[spot] = self._on_top[spot] = CELL_CODES[PICKUP] if is_waiting else NOTHING

    def _stations_at(self, cells: Integers) -> Integers:
        if not self.moving_stations:
            return super()._stations_at(cells)
        on_ground = station_numbers(self._ground.take(self._spots_of(cells)))
        return self._stations_of_rows(cells) | on_ground

    def show(self, cells: Integers, has_item: Flags, people: Integers) -> None:
        """Put robots ``[B * R]`` and people ``[B, P]`` in their cells."""
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
        """Return row and column of the charger nearest to each cell, or ``NOWHERE``; ``[N, 2]``."""
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
    """Raise if the spots of all windows would take more than ``MAX_TABLE_BYTES``."""
    needed = robots * side**2 * np.dtype(np.intp).itemsize
    if needed > MAX_TABLE_BYTES:
        raise LayoutError(
            f"windows of {side} x {side} around {robots} robots take {needed} bytes; "
            f"MAX_TABLE_BYTES = {MAX_TABLE_BYTES} are allowed"
        )


def _nearest_chargers(layout: Layout) -> NDArray[np.int32]:
    """Return row and column of the nearest charger of every cell, ``[H * W, 2]``."""
    cells = nearest(layout, layout.chargers).ravel()
    places = layout.places(cells).astype(np.int32)
    places[cells < 0] = NOWHERE
    return places
