"""The tiles of a layout: walls, shelves, stations, and what covers the floor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import PathPatch, Rectangle

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import (
    BOARD,
    COLORS,
    ICE,
    ICE_WAVE,
    INK,
    PAPER,
    SHELF,
    UNKNOWN,
    UNKNOWN_STRIPE,
)
from warehouse_core.viz.axes.glyphs import letter_path
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP, WALL, Cell

BAND = 0.22
"""Thickness of walls along the border, in cells; the rest of their cells is left blank."""

INSET, MIN_STATION_POINTS = 0.06, 6.5
"""Room around the square of a station in its cell, and least side of the square in points."""

MIN_BOARDS, MIN_WAVES = 7.0, 9.0
"""Least sides of cells, in points, that show the boards of shelves and waves."""

LETTER, MIN_LETTER_POINTS = 0.3, 6.0
"""Size of the letter of a station, in cells, and its minimum."""

TileBounds = tuple[float, float, float, float]
"""Left, top, right and bottom, in cells."""


def draw_tiles(
    axes: Axes, rows: Sequence[str], cell_points: float, slippery: Sequence[Cell] = ()
) -> list[Artist]:
    """Draw what does not move into axes whose unit is a cell of ``cell_points``, and return it."""
    walls = cells_of(WALL, rows)
    size = len(rows), len(rows[0])
    border = {cell for cell in walls if is_on_border(cell, size)}
    shelves = [cell for cell in walls if cell not in border]
    drawn: list[Artist] = [
        *_ice(axes, slippery, cell_points),
        _boxes(axes, [_whole(cell) for cell in border], PAPER),
        _boxes(axes, [_band(cell, size) for cell in border], COLORS[WALL]),
        *_shelves(axes, shelves, cell_points),
    ]
    inset = min(INSET, 0.5 - MIN_STATION_POINTS / cell_points / 2)
    for tile in (PICKUP, DROPOFF, CHARGER):
        cells = cells_of(tile, rows)
        drawn.append(_boxes(axes, [_whole(cell, inset) for cell in cells], COLORS[tile]))
        drawn += [_letter(axes, cell_points, tile, cell) for cell in cells]
    unseen = cells_of(UNSEEN, rows)
    if unseen:
        drawn.append(_boxes(axes, [_whole(cell) for cell in unseen], UNKNOWN))
        stripes = [((col, row + 1), (col + 1, row)) for row, col in unseen]
        style: dict[str, Any] = {"colors": [UNKNOWN_STRIPE], "linewidths": cell_points / 14}
        drawn.append(axes.add_collection(LineCollection(stripes, zorder=1, **style)))
    return drawn


def cells_of(tile: str, rows: Sequence[str]) -> list[Cell]:
    """Return the cells of some rows that have a tile."""
    return [
        (row, col) for row, line in enumerate(rows) for col, here in enumerate(line) if here == tile
    ]


def is_on_border(cell: Cell, size: tuple[int, int]) -> bool:
    """Return whether a cell is in the outermost ring of a layout of ``size`` rows and columns."""
    return any(place in (0, length - 1) for place, length in zip(cell, size, strict=True))


def _whole(cell: Cell, inset: float = 0.0) -> TileBounds:
    row, col = cell
    return col + inset, row + inset, col + 1 - inset, row + 1 - inset


def _band(cell: Cell, size: tuple[int, int]) -> TileBounds:
    """Return the part of a wall on the border that is next to the inside of the layout."""
    (row, col), (height, width) = cell, size
    outer = 1 - BAND
    return (
        col + outer * (col == 0 < width - 1),
        row + outer * (row == 0 < height - 1),
        col + 1 - outer * (col == width - 1 > 0),
        row + 1 - outer * (row == height - 1 > 0),
    )


def _boxes(axes: Axes, boxes: Sequence[TileBounds], color: Any, **style: Any) -> Artist:
    # A thin edge without antialiasing leaves no seam between neighbours.
    style = {"facecolor": color, "edgecolor": color, "linewidth": 0.4} | style
    rectangles = [Rectangle((x, y), right - x, bottom - y) for x, y, right, bottom in boxes]
    return axes.add_collection(PatchCollection(rectangles, antialiased=False, zorder=1, **style))


def _shelves(axes: Axes, cells: Sequence[Cell], cell_points: float) -> Iterator[Artist]:
    """Draw walls inside the border, with two boards across each."""
    if not cells:
        return
    yield _boxes(axes, [_whole(cell) for cell in cells], SHELF)
    if cell_points >= MIN_BOARDS:
        boards = [
            (col + 0.12, row + top, col + 0.88, row + top + 1 / 12)
            for row, col in cells
            for top in (0.3, 0.62)
        ]
        yield _boxes(axes, boards, BOARD, linewidth=0)


def _ice(axes: Axes, cells: Sequence[Cell], cell_points: float) -> Iterator[Artist]:
    """Draw waves on slippery floor."""
    if not cells:
        return
    yield _boxes(axes, [_whole(cell, 0.02) for cell in cells], ICE)
    if cell_points >= MIN_WAVES:
        x = np.linspace(0.12, 0.88, 17)
        wave = np.column_stack([x, 0.06 * np.sin(4 * np.pi * x)])
        waves = [wave + np.array((col, row + y)) for row, col in cells for y in (0.25, 0.5, 0.75)]
        width = max(0.8, cell_points / 22)
        yield axes.add_collection(
            LineCollection(waves, colors=[ICE_WAVE], linewidths=width, zorder=1)
        )


def _letter(axes: Axes, cell_points: float, tile: str, cell: Cell) -> Artist:
    row, col = cell
    size = max(LETTER, MIN_LETTER_POINTS / cell_points)
    path = letter_path(tile, size, (col + 0.07, row + 0.06), (0.0, 0.0))
    return axes.add_patch(PathPatch(path, facecolor=INK, linewidth=0, zorder=2))
