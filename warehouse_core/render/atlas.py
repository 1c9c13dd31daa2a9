"""The tiles of pictures, each drawn once for each size, with NumPy only.

Their geometry is defined in ``tiles.json``. ``T`` is the side of a tile in pixels. A tile is first
drawn with ``n = T * samples`` points per side, each of a single colour, and these points are then
averaged. A shape is a mask of points, ``[n, n]`` or broadcastable to it. It is computed from the
coordinates of the points in pixels, ``x`` ``[1, n]`` and ``y`` ``[n, 1]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from warehouse_core.render.palette import (
    COLORS,
    FAINT,
    INK,
    ITEM,
    LOOK,
    PAPER,
    Color,
    blend,
    color_named,
)
from warehouse_core.world.tiles import (
    CELL_CODES,
    CHARGER,
    DROPOFF,
    EMPTY,
    OTHER_EMPTY,
    OTHER_LOADED,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    TILES,
    WALL,
)

Pixels = NDArray[np.uint8]
"""Pixels with red, green and blue from 0 to 255 in the last axis."""

Places = NDArray[np.float64]
Shape = NDArray[np.bool_]

NO_ROBOT, UNSEEN, WAITING_ITEM, SLIPPERY = "", "?", "item", "ice"

STATIONS = (PICKUP, DROPOFF, CHARGER)

SHELVES, BORDERS = "shelf", ("N", "S", "W", "E", "NW", "NE", "SW", "SE")
"""Sign of walls that are shelves, and signs of walls of a border, named after their sides."""

TEXTURES = {UNSEEN: "unseen", SHELVES: "shelf", SLIPPERY: "ice"}
"""Names of textures and of the colours below them, by tile or sign."""

FINE = ("board", "wave")
"""Colours of the parts of textures that tiles smaller than ``MIN_OUTLINED`` do not have."""

CELLS = (
    *((sign, NO_ROBOT) if sign in TILES else (EMPTY, sign) for sign in CELL_CODES),
    (UNSEEN, NO_ROBOT),
    *product(STATIONS, (ROBOT_EMPTY, ROBOT_LOADED)),
    *product(STATIONS, (PERSON,)),
    (PICKUP, WAITING_ITEM),
    *product((WALL,), (SHELVES, *BORDERS)),
    *product((EMPTY, *STATIONS), (SLIPPERY,)),
)
"""Everything that can be painted: each tile with each sign on it, such as a robot.

The code of a cell is its index in this tuple. The first cells are the characters of an observed
window in the order of ``CELL_CODES``, so the codes of a window can be painted directly.
"""

CODES = {cell: code for code, cell in enumerate(CELLS)}
"""The code of each tile with the sign on it."""

ROBOT_CODES = np.array(
    [
        [CODES.get((tile, robot), 255) for tile, _ in CELLS[: CODES[CHARGER, NO_ROBOT] + 1]]
        for robot in (ROBOT_EMPTY, ROBOT_LOADED)
    ],
    np.uint8,
)
"""The code of each cell with a robot on it, ``[loaded, code without robot]``; 255 for walls."""
ROBOT_CODES.setflags(write=False)

BAND = 1 - LOOK["border"]["outer"]
"""Thickness of a border, in cells."""

ROBOT_RADIUS, OUTLINE = LOOK["robot"]["radius"], LOOK["robot"]["rim"]
"""Radius of the robot and width of the line around it, in cells."""

PERSON_RADIUS = LOOK["shapes"]["H"][1][0]
"""Distance of the corners of a person from the centre, in cells."""

CAPITAL = 0.73
"""Height of a capital letter, as a share of the font size."""

MIN_RADIUS, MIN_PERSON, MIN_CORNER_LETTER, MIN_ROBOT_LETTER = 3.0, 3.75, 6, 6
"""Least sizes in pixels; smaller shapes would be unrecognisable."""

MIN_OUTLINED, MIN_LETTERED, MIN_BOTH_LETTERED = 10, 16, 24
"""Least sides of tiles, in pixels, for an outline, for a letter, and for two letters."""

WIDTHS = {
    PICKUP: 0.82, DROPOFF: 0.92, CHARGER: 0.9, ROBOT_EMPTY: 0.86, ROBOT_LOADED: 0.58,
    OTHER_EMPTY: 0.96, OTHER_LOADED: 0.78, PERSON: 0.86,
}  # fmt: skip
"""Widths of the letters, as shares of the height of a capital."""

LOWERCASE = (ROBOT_LOADED, OTHER_LOADED)

BODIES = (ROBOT_EMPTY, ROBOT_LOADED, PERSON)

SAMPLES, MAX_SAMPLED = 8, 40
"""Number of points along each side of a pixel, which measure how much of it a shape covers. Tiles
with a side above ``MAX_SAMPLED`` pixels have half as many, which takes a quarter of the time."""


@cache
def atlas(tile_pixels: int) -> Pixels:
    """Return the pictures of all ``CELLS``, ``[N, T, T, 3]``, as a read-only array."""
    tiles = np.stack([tile_of(code, tile_pixels) for code in range(len(CELLS))])
    tiles.setflags(write=False)
    return tiles


@cache
def tile_of(code: int, tile_pixels: int) -> Pixels:
    """Return the picture of one of the ``CELLS``, ``[T, T, 3]``."""
    return _draw_cell(*CELLS[code], tile_pixels)


def noses(tile_pixels: int) -> NDArray[np.bool_]:
    """Return masks of the nose of a robot for the headings N, E, S and W, ``[4, T, T]``.

    The nose is a triangle outside the rim of the disc. Tiles of less than 4 pixels have none.
    """
    (tip, _), (base, half), _ = LOOK["shapes"]["nose"]
    along = (np.arange(tile_pixels) + 0.5) / tile_pixels - 0.5
    forward, aside = -along[:, None], np.abs(along)
    # The nose has all pixels that the triangle touches, because small tiles have so few of them.
    reach, near = tip - forward + 0.5 / tile_pixels, aside - 0.5 / tile_pixels
    north = (forward > ROBOT_RADIUS) & (near * (tip - base) <= half * reach)
    return np.stack([np.rot90(north, -quarters) for quarters in range(4)])


def _draw_cell(tile: str, robot: str, side: int) -> Pixels:
    samples = SAMPLES if side <= MAX_SAMPLED else SAMPLES // 2
    points = np.empty((side * samples, side * samples, 3), np.uint8)
    along = (np.arange(side * samples) + 0.5) / samples
    x, y = along[None, :], along[:, None]
    texture = TEXTURES.get(robot or tile)
    ground = COLORS[WALL if tile == WALL else EMPTY]
    points[:] = color_bytes(color_named(texture) if texture else ground)
    if texture:
        _draw_texture(points, x, y, side, texture)
    elif tile == WALL:
        outside = {"N": y < (1 - BAND) * side, "S": y > BAND * side}
        outside |= {"W": x < (1 - BAND) * side, "E": x > BAND * side}
        for edge in robot:
            _fill(points, outside[edge], PAPER)
    else:
        # Lines are always one pixel wide; on small tiles they are paler instead of narrower.
        _fill(points, (x < 1) | (y < 1), blend(COLORS[EMPTY], FAINT, min(1.0, side / 24)))
    inset = round(LOOK["station"]["inset"] * side)
    if tile in STATIONS:
        square = _within(inset, x, side - inset) & _within(inset, y, side - inset)
        _fill(points, square, COLORS[tile])
    if robot == WAITING_ITEM:
        middle = LOOK["item"]["place"] * side
        _draw_item(points, x - middle, y - middle, side)
    elif robot and robot != SLIPPERY and tile != WALL:
        _draw_robot(points, x - side / 2, y - side / 2, side, robot)
    if tile in STATIONS and side >= (MIN_BOTH_LETTERED if robot in BODIES else MIN_LETTERED):
        corner = max(round(LOOK["station"]["corner"] * side), inset + 1)
        height = max(MIN_CORNER_LETTER, round(CAPITAL * LOOK["station"]["letter"] * side))
        _write(points, tile, x - corner, y - corner, round(WIDTHS[tile] * height), height)
    mixed = points.reshape(side, samples, side, samples, 3).mean(axis=(1, 3))
    pixels: Pixels = np.rint(mixed).astype(np.uint8)
    return pixels


def _draw_texture(points: Pixels, x: Places, y: Places, side: int, name: str) -> None:
    """Draw the polygons of a texture, without those that are too fine for small tiles."""
    for color, polygons in LOOK["textures"][name].items():
        if side >= MIN_OUTLINED or color not in FINE:
            for corners in polygons:
                _fill(points, _polygon(x / side, y / side, corners), color_named(color))


def _polygon(x: Places, y: Places, corners: Sequence[Sequence[float]]) -> Shape:
    """Return the points inside a polygon, from which a ray crosses an odd number of edges."""
    shape = np.zeros(np.broadcast_shapes(x.shape, y.shape), bool)
    for (left, top), (right, bottom) in pairwise([*corners, corners[0]]):
        if top != bottom:
            edge = left + (right - left) * (y - top) / (bottom - top)
            shape ^= ((top > y) != (bottom > y)) & (x < edge)
    return shape


def _draw_robot(points: Pixels, x: Places, y: Places, side: int, robot: str) -> None:
    """Draw a robot as a disc, or a person as a diamond, with the centre at 0, 0."""
    is_person = robot == PERSON
    least = min(MIN_PERSON if is_person else MIN_RADIUS, side / 2)
    radius = max((PERSON_RADIUS if is_person else ROBOT_RADIUS) * side, least)
    outline = _outline(side)
    distance = np.abs(x) + np.abs(y) if is_person else np.hypot(x, y)
    _fill(points, distance < radius + outline / 2, INK)
    _fill(points, distance < radius - outline / 2, COLORS[robot])
    if robot == ROBOT_LOADED:
        _draw_item(points, x, y, side)
    if side >= MIN_LETTERED:
        capital = max(MIN_ROBOT_LETTER, round(CAPITAL * LOOK["robot"]["letter"] * side))
        width = _centred(WIDTHS[robot] * capital, side)
        height = _centred(0.76 * capital if robot in LOWERCASE else capital, side)
        _write(points, robot, x + width / 2, y + height / 2, width, height)


def _outline(side: int) -> float:
    """Return the width of the line around robots and items, in pixels."""
    return max(OUTLINE * side, 0.5) if side >= MIN_OUTLINED else 0.0


def _draw_item(points: Pixels, x: Places, y: Places, side: int) -> None:
    """Draw an item, a box with the centre at 0, 0; in small tiles it is only a dark square."""
    half, outline = LOOK["item"]["side"] * side / 2, _outline(side)
    distance = np.maximum(np.abs(x), np.abs(y))
    _fill(points, distance < half + outline / 2, INK)
    if side >= MIN_LETTERED:
        _fill(points, distance < half - outline / 2, ITEM)


def _write(points: Pixels, letter: str, x: Places, y: Places, width: int, height: int) -> None:
    """Draw a letter with its top left corner at 0, 0, either light with a dark rim or dark."""
    shape = partial(_letter, letter, width=width, height=height)
    if letter not in LOWERCASE:
        rim = max(1, round(LOOK["lines"]["letter"] / CAPITAL / 2 * height))
        for right, down in product((-rim, 0, rim), repeat=2):
            _fill(points, shape(x + right, y + down), INK)
    _fill(points, shape(x, y), INK if letter in LOWERCASE else PAPER)


def _centred(length: float, side: int) -> int:
    """Return about ``length``, but odd if ``side`` is odd and else even, so it can be centred."""
    length = round(length)
    return length + (side - length) % 2


def _letter(letter: str, x: Places, y: Places, width: int, height: int) -> Shape:
    """Return the shape of a letter in a box with its top left corner at 0, 0.

    The strokes are a whole number of pixels wide, because small letters would otherwise be blurred.
    """
    is_capital = letter not in LOWERCASE
    thick = max(1, round((0.26 if is_capital else 0.32) * height))
    thin = max(1, round((0.18 if is_capital else 0.28) * height))
    if letter in (CHARGER, OTHER_EMPTY, OTHER_LOADED):
        return _ring(x, y, width, height, thick, thin, is_open=letter == CHARGER)
    stem = _within(0, x, thick) & _within(0, y, height)
    if letter == PERSON:
        bar = _within(0, x, width) & (np.abs(2 * y - height) < thin)
        return stem | (_within(width - thick, x, width) & _within(0, y, height)) | bar
    if not is_capital:
        bend = 0.6 * height
        arm = _oval(x - width, y - bend, width - 0.6 * thick, bend)
        hollow = _oval(x - width, y - bend, width - thick, bend - thin)
        return stem | (arm & ~hollow & (x < width) & (y < bend))
    bottom = height if letter == DROPOFF else round(0.55 * height + 0.5 * thin)
    right = 0.94 * width if letter == ROBOT_EMPTY else width
    hollow = _bow(x - thick, y - thin, right - 2 * thick, bottom - 2 * thin)
    shape = stem | (_bow(x, y, right, bottom) & ~hollow)
    if letter == ROBOT_EMPTY:
        down = (y - bottom + thin) / (height - bottom + thin)
        heel = width * (0.62 + 0.38 * down)
        shape |= _within(0, down, 1) & _within(0, heel - x, 1.1 * thick)
    return shape


def _ring(
    x: Places, y: Places, width: int, height: int, thick: int, thin: int, *, is_open: bool
) -> Shape:
    """Return the shape of an O or, if it is open, of a C, with the top left corner at 0, 0."""
    back = width - x
    outer = _bow(back, y, width, height)
    if is_open:
        return outer & ~_bow(back + thick, y - thin, width, height - 2 * thin)
    inner = y - thin, width - 2 * thick, height - 2 * thin
    hollow = _bow(back - thick, *inner) & _bow(x - thick, *inner)
    return outer & _bow(x, y, width, height) & ~hollow


def _bow(x: Places, y: Places, right: float, bottom: float) -> Shape:
    """Return the shape of a box from 0, 0 with a rounded right end."""
    half = bottom / 2
    bend = min(1.2 * half, 0.85 * right)
    return (x > 0) & _oval(np.maximum(x - right + bend, 0), y - half, bend, half)


def _oval(x: Places, y: Places, half_width: float, half_height: float) -> Shape:
    return (x * half_height) ** 2 + (y * half_width) ** 2 < (half_width * half_height) ** 2


def _within(low: float, place: Places, high: float) -> Shape:
    return (place > low) & (place < high)


def _fill(points: Pixels, shape: Shape, color: Color) -> None:
    points[np.broadcast_to(shape, points.shape[:2])] = color_bytes(color)


@cache
def color_bytes(color: Color) -> NDArray[np.uint8]:
    """Return a colour as a read-only array of three bytes."""
    color_in_bytes = np.array([round(255 * part) for part in color], np.uint8)
    color_in_bytes.setflags(write=False)
    return color_in_bytes
