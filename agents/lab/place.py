"""Where episodes take place: the walls, and what of stations and start is drawn at random."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from warehouse_core import Cell, Layout, LayoutError
from warehouse_core.task.starts import START, STATIONS, empty_cells

RANDOM = "random"
"""Name in place of a layout's: another layout for each seed."""


class Stations(StrEnum):
    """Where pickup and dropoff come from."""

    DRAWN = "drawn"
    KEPT = "kept"


class Place(NamedTuple):
    """Where episodes take place.

    Attributes:
        layout: walls, and stations if these are kept.
        start_pos: start, ``None`` for a random one.
        randomize: choice of what is drawn, see ``WarehouseEnv.reset``.
    """

    layout: Layout
    start_pos: Cell | None
    randomize: bool | str

    @property
    def stations(self) -> Stations:
        """Where pickup and dropoff come from."""
        return Stations.DRAWN if self.randomize in (True, STATIONS) else Stations.KEPT


def usual_stations(layout: Layout, *, is_default: bool) -> Stations:
    """Return what is done with the stations of a layout if nothing is said.

    They are kept if it has any, but in the default layout they are drawn, as in the chapter.
    """
    has_own = layout.pickups + layout.dropoffs and not is_default
    return Stations.KEPT if has_own else Stations.DRAWN


def check_stations(layout: Layout, stations: Stations, name: object, to_draw: str) -> None:
    """Raise ``LayoutError`` if a layout has no station of a kind to keep, or no room to draw them.

    The message has the name of the layout, and the words by which a user lets them be drawn.
    """
    if stations is Stations.DRAWN:
        empty = len(empty_cells(layout))
        if empty < 2:
            raise LayoutError(
                f"{name}: pickup and dropoff are drawn from the empty cells; allowed: two or more, "
                f"and there are {empty}"
            )
        return
    for kind, cells in (("pickup P", layout.pickups), ("dropoff D", layout.dropoffs)):
        if not cells:
            raise LayoutError(f"{name}: there is no {kind}; add one, or use {to_draw}")


def what_to_draw(stations: Stations, start: Cell | None = None) -> bool | str:
    """Return the ``randomize`` of ``WarehouseEnv.reset``; a ``start`` that is given stays."""
    if stations is Stations.DRAWN:
        return True if start is None else STATIONS
    return START if start is None else False
