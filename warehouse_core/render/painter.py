"""Pictures of warehouses, made of square tiles, with NumPy only.

They look like the cells of a replay. Painting is fast enough for a film of every step of a
training, because each tile is drawn only once and then copied into pictures. ``T`` is the side of a
tile in pixels, ``H, W`` are the height and width of a layout in cells, and ``...`` is any leading
shape, such as a batch.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.render.atlas import (
    CODES,
    NO_ROBOT,
    SHELVES,
    SLIPPERY,
    UNSEEN,
    WAITING_ITEM,
    Pixels,
    atlas,
    color_bytes,
    noses,
    tile_of,
)
from warehouse_core.render.palette import BATTERY, FAINT, INK, Color
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED, WALL, Cell

MAX_TILE_PIXELS = 256

DEFAULT_TILE_PIXELS, DEFAULT_PICTURE_PIXELS = 40, 1000
"""Largest side of a tile and of a picture, in pixels, that ``tile_pixels_for`` chooses."""


def tile_pixels_for(height: int, width: int) -> int:
    """Return a suitable side of a tile, in pixels, for a map of ``height`` x ``width`` cells.

    It is even, because most video encoders require even sides.

    Example:
        >>> from warehouse_core.render import tile_pixels_for
        >>> tile_pixels_for(7, 12), tile_pixels_for(100, 100)
        (40, 10)
    """
    height, width = whole_number("height", height, 1), whole_number("width", width, 1)
    pixels = min(DEFAULT_TILE_PIXELS, DEFAULT_PICTURE_PIXELS // max(height, width))
    return max(2, pixels - pixels % 2)


class TilePainter:
    """A painter of warehouses with tiles of one size.

    Args:
        tile_pixels: ``T``, from 2 to ``MAX_TILE_PIXELS``; tiles have letters from 16 pixels on.

    Raises:
        ValueError: ``tile_pixels`` is out of range.
        TypeError: it is not an integer.

    Example:
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> from warehouse_core.render import TilePainter
        >>> TilePainter(16).picture(DEFAULT_LAYOUT, (1, 1), False).shape
        (112, 192, 3)
    """

    def __init__(self, tile_pixels: int) -> None:
        self.tile_pixels = whole_number("tile_pixels", tile_pixels, 2, MAX_TILE_PIXELS)
        self._atlas, self._noses = atlas(self.tile_pixels), noses(self.tile_pixels)
        self._layout: Layout | None = None
        self._background: Pixels = np.empty((0, 0, 3), np.uint8)

    def paint(self, codes: ArrayLike) -> Pixels:
        """Return pictures ``[..., H*T, W*T, 3]`` of cells given by their codes ``[..., H, W]``.

        Raises:
            IndexError: a code does not exist.
        """
        side = self.tile_pixels
        # A row of pixels of a tile is copied as a single item.
        rows = self._atlas.reshape(-1, 3 * side).view(np.dtype((np.void, 3 * side)))[:, 0]
        first = np.multiply(codes, side, dtype=np.intp)
        *batch, height, width = first.shape
        painted = rows.take(first[..., :, None, :] + np.arange(side)[:, None])
        return painted.view(np.uint8).reshape(*batch, height * side, width * side, 3)

    def picture(self, layout: Layout, robot_cell: Cell, loaded: bool) -> Pixels:
        """Return a new picture of a layout with a robot and the items at the pickups.

        There are no items while the robot is loaded, and a robot hides the item in its own cell.
        See ``fleet_picture``.
        """
        robot = (robot_cell, ROBOT_LOADED if loaded else ROBOT_EMPTY)
        waiting = [cell for cell in layout.pickups if cell != robot_cell and not loaded]
        return self._picture(layout, [robot, *((cell, WAITING_ITEM) for cell in waiting)])

    def fleet_picture(
        self,
        layout: Layout,
        robots: Iterable[tuple[Cell, bool]],
        people: Iterable[Cell] = (),
        headings: Iterable[int] = (),
    ) -> Pixels:
        """Return a new picture of a layout with robots and people, ``[H*T, W*T, 3]``.

        The picture of the previous layout is stored. If the same ``layout`` object is given again,
        the stored picture is copied, and only the tiles of robots and people are replaced.

        Args:
            layout: layout to paint.
            robots: cell of each robot, and ``True`` if it is loaded.
            people: cells of the people.
            headings: heading of each robot, 0 to 3 for N, E, S and W, shown by a nose; empty for
                robots without headings.

        Raises:
            KeyError: a robot or a person is on a wall.
        """
        placed = [(cell, ROBOT_LOADED if loaded else ROBOT_EMPTY) for cell, loaded in robots]
        picture = self._picture(layout, [*placed, *((cell, PERSON) for cell in people)])
        for (cell, _), heading in zip(placed, headings, strict=False):
            self._tile(picture, cell)[self._noses[heading]] = color_bytes(INK)
        return picture

    def _tile(self, picture: Pixels, cell: Cell) -> Pixels:
        """Return the part of a picture that shows a cell, as a view."""
        (row, col), side = cell, self.tile_pixels
        return picture[row * side : (row + 1) * side, col * side : (col + 1) * side]

    def _picture(self, layout: Layout, placed: Iterable[tuple[Cell, str]]) -> Pixels:
        if layout is not self._layout:
            self._background, self._layout = self.paint(codes_of(layout.rows)), layout
        picture = self._background.copy()
        for (row, col), sign in placed:
            self._tile(picture, (row, col))[:] = self._atlas[CODES[layout.rows[row][col], sign]]
        return picture


def codes_of(rows: Sequence[str], slippery: Iterable[Cell] = ()) -> NDArray[np.uint8]:
    """Return the codes of rows of tiles, ``[H, W]``, with slippery cells.

    Walls inside the layout are shelves. A border of walls is as thin as in a replay. Tiles may be
    ``UNSEEN``, also in a border of walls.
    """
    codes = np.array([[CODES[tile, NO_ROBOT] for tile in line] for line in rows], np.uint8)
    is_wall = codes == CODES[WALL, NO_ROBOT]
    codes[is_wall] = CODES[WALL, SHELVES]
    for row, col in slippery:
        sign = rows[row][col], SLIPPERY
        codes[row, col] = CODES.get(sign, codes[row, col])
    inside = np.zeros_like(is_wall)
    inside[1:-1, 1:-1] = True
    is_edge = is_wall | (codes == CODES[UNSEEN, NO_ROBOT])
    if not is_edge[~inside].all() or not inside.any():
        codes[is_wall & ~inside] = CODES[WALL, NO_ROBOT]
        return codes
    for side, line in (("N", 0), ("S", -1), ("W", (..., 0)), ("E", (..., -1))):
        codes[line] = np.where(is_wall[line], CODES[WALL, side], codes[line])
    for corner in ("NW", "NE", "SW", "SE"):
        place = -("S" in corner), -("E" in corner)
        if is_wall[place]:
            codes[place] = CODES[WALL, corner]
    return codes


def paint_once(codes: NDArray[np.uint8], tile_pixels: int) -> Pixels:
    """Return the same picture as a ``TilePainter``, but draw only the tiles that it has."""
    height, width = codes.shape
    used, places = np.unique(codes, return_inverse=True)
    tiles = np.stack([tile_of(code, tile_pixels) for code in used.tolist()])
    painted: Pixels = tiles[places.reshape(codes.shape)].swapaxes(1, 2)
    return painted.reshape(height * tile_pixels, width * tile_pixels, 3)


def bar(share: float, width: int, height: int, color: Color = BATTERY) -> Pixels:
    """Return a bar ``[height, width, 3]`` that is filled from the left up to a share.

    The share is clipped to 0..1. The last pixel of the filling is blended with the background, to
    show small changes. There is a margin of one pixel, unless the bar is less than 4 pixels high.
    """
    edge = 1 if height >= 4 else 0
    ground, filling = color_bytes(FAINT), color_bytes(color)
    pixels = np.empty((height, width, 3), np.uint8)
    pixels[:] = ground
    inner = pixels[edge : height - edge, edge:]
    end = (width - 2 * edge) * min(max(share, 0.0), 1.0)
    whole = int(end)
    inner[:, :whole] = filling
    if end > whole:
        inner[:, whole] = np.rint(
            ground + (end - whole) * np.subtract(filling, ground, dtype=float)
        )
    return pixels
