"""Where episodes take place: the layout, and which of stations and start are random."""

from __future__ import annotations

from enum import StrEnum

from warehouse_core import Cell, Layout, LayoutError
from warehouse_core.task.starts import START, STATIONS, empty_cells
from warehouse_core.wording import counted

RANDOM = "random"
"""Name that stands for a different random layout for each seed."""


class Stations(StrEnum):
    """Source of pickup and dropoff: drawn at random, or kept from the layout."""

    DRAWN = "drawn"
    KEPT = "kept"

    @property
    def words(self) -> str:
        """Words for this source in an output."""
        return "random stations" if self is Stations.DRAWN else "stations of the layout"


def default_stations(layout: Layout, *, is_default: bool) -> Stations:
    """Return the source of the stations if the user does not choose one.

    Stations of a layout are kept if it has any. In the default layout they are drawn at random, as
    in the chapter.
    """
    has_own = layout.pickups + layout.dropoffs and not is_default
    return Stations.KEPT if has_own else Stations.DRAWN


def check_stations(layout: Layout, stations: Stations, name: object, to_draw: str) -> None:
    """Raise ``LayoutError`` if stations to keep, or empty cells to draw them in, are missing.

    Args:
        layout: layout to check.
        stations: source of its stations.
        name: name of the layout in the message.
        to_draw: setting that makes stations random, for the message.
    """
    if stations is Stations.DRAWN:
        empty = len(empty_cells(layout))
        if empty < 2:
            raise LayoutError(
                f"{name}: it has {counted(empty, 'empty cell')}; random stations need two or more"
            )
        return
    for kind, cells in (("pickup P", layout.pickups), ("dropoff D", layout.dropoffs)):
        if not cells:
            raise LayoutError(f"{name}: there is no {kind}; add one, or use {to_draw}")


def what_to_draw(stations: Stations, start: Cell | None = None) -> bool | str:
    """Return the argument ``randomize`` of ``WarehouseEnv.reset`` that keeps a given ``start``."""
    if stations is Stations.DRAWN:
        return True if start is None else STATIONS
    return START if start is None else False
