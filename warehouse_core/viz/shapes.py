"""Shapes that an artist draws quickly into axes, and functions that make paths of polygons.

The unit is a unit of the horizontal axis: a cell on a floor, a step or a second in a chart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D, Bbox
from numpy.typing import ArrayLike, NDArray

from warehouse_core.render.palette import LOOK, Color, color_named
from warehouse_core.viz.axes import POINTS
from warehouse_core.viz.tracks.track import Point

DOTS = (0.01, 1.6)
"""Dash pattern of dots, in multiples of the line width."""

SNAP = 2
"""Pixels by which matplotlib may move edges, to draw them sharply."""

SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2
BAR = SQUARE + 0.5
CIRCLE = np.array([(math.cos(turn), math.sin(turn)) for turn in np.linspace(0, 2 * math.pi, 33)])
"""Shapes with a side or radius of 1 around 0, 0, except for the bar, whose corner is at 0, 0."""


Points = NDArray[np.float64]


class Shape(NamedTuple):
    """A path in units of cells, with an optional filling and an optional line around it.

    A colour may be given by its name in the palette. The ``width`` of the line is in cells, and its
    ``dashes`` are in multiples of the width.
    """

    path: Path
    fill: Color | str | None = None
    line: Color | str | None = None
    width: float = 0.0
    dashes: Sequence[float] = ()
    alpha: float = 1.0


class Shapes(Artist):
    """An artist that draws shapes in their order, in axes whose unit is a cell.

    Attributes:
        shapes: shapes that it draws.
        needed: part of the figure, in pixels, outside of which the next ``draw`` needs to draw
            nothing, or ``None``.
    """

    def __init__(self, zorder: float = 0) -> None:
        super().__init__()
        self.set_zorder(zorder)
        self.shapes: Sequence[Shape] = ()
        self.needed: Bbox | None = None

    def show(self, shapes: Iterable[Shape]) -> None:
        """Draw these shapes from now on."""
        self.shapes = [shape for shape in shapes if np.size(shape.path.vertices)]
        self.stale = True

    def draw(self, renderer: Any) -> None:
        """Draw the shapes."""
        if not self.get_visible():
            return
        assert self.axes is not None, "shapes are in axes"
        # Renderers draw paths in pixels, but the widths of lines in points.
        to_pixels, cell = self.axes.transData, cell_of(self.axes) / renderer.points_to_pixels(1.0)
        for path, fill, line, width, dashes, alpha in self.shapes:
            style = renderer.new_gc()
            style.set_linewidth(width * cell if line else 0)
            style.set_foreground(rgb_of(line or "ink"))
            style.set_joinstyle("round")
            style.set_capstyle("round" if dashes == DOTS else "butt")
            if dashes:
                style.set_dashes(0, [dash * width * cell for dash in dashes])
            if alpha < 1 and self.needed is not None:
                # Only translucent shapes are large. Their edges are horizontal and vertical, so
                # that clipping changes no pixels inside.
                style.set_clip_rectangle(self.needed)
            renderer.draw_path(style, path, to_pixels, (*rgb_of(fill), alpha) if fill else None)
            style.restore()
        self.stale, self.needed = False, None

    def changed_since(self, drawn: Sequence[Shape]) -> Bbox | None:
        """Return the part of the figure, in pixels, that has changed since ``drawn`` was drawn."""
        assert self.axes is not None, "shapes are in axes"
        changed, widest = [], 0.0
        for before, after in zip_longest(drawn, self.shapes):
            corners = changed_corners(before, after)
            if len(corners):
                changed.append(corners)
                widest = max(widest, *(shape.width for shape in (before, after) if shape))
        if not changed:
            return None
        pixels = self.axes.transData.transform(np.concatenate(changed))
        margin = widest * cell_of(self.axes) / 2 + SNAP
        return Bbox([pixels.min(axis=0) - margin, pixels.max(axis=0) + margin])


def changed_corners(before: Shape | None, after: Shape | None) -> Points:
    """Return the corners ``[N, 2]`` before and after a change, without unchanged polygons."""
    if not before or not after or before[1:] != after[1:]:
        return np.concatenate([shape.path.vertices for shape in (before, after) if shape])
    old, new = np.asarray(before.path.vertices), np.asarray(after.path.vertices)
    codes: Any = after.path.codes
    if len(old) != len(new) or not np.array_equal(before.path.codes, codes):  # type: ignore[arg-type]
        return np.concatenate([old, new])
    moved = (old != new).any(axis=1)
    if not moved.any():
        return new[:0]
    polygons = np.cumsum(codes == Path.MOVETO)
    has_moved = np.bincount(polygons, moved) > 0
    corners: Points = np.concatenate([old, new])[np.tile(has_moved[polygons], 2)]
    return corners


def rgb_of(color: Color | str) -> Color:
    """Return a colour, which may be given by its name."""
    return color_named(color) if isinstance(color, str) else color


def cell_of(axes: Any) -> float:
    """Return the side of a cell of axes, in pixels."""
    left, right = axes.get_xlim()
    return float(axes.bbox.width / (right - left))


def line_width(axes: Any, points: float) -> float:
    """Return the width of a line with this number of points, in units of the axes."""
    return float(points * axes.figure.dpi / POINTS / cell_of(axes))


def stamped(shape: ArrayLike, places: ArrayLike) -> Path:
    """Return one path with copies of a polygon ``[N, 2]`` at the positions ``[K, 2]``."""
    return polygons(np.asarray(places, float).reshape(-1, 1, 2) + np.asarray(shape))


def polygons(corners: ArrayLike) -> Path:
    """Return one path with closed polygons of the same number of corners, ``[K, N, 2]``."""
    each = np.asarray(corners, float)
    count, points, _ = each.shape if each.size else (0, 0, 2)
    codes = np.full((count, points + 1), Path.LINETO, np.uint8)
    codes[:, :1], codes[:, -1:] = Path.MOVETO, Path.CLOSEPOLY
    closed = np.concatenate([each, each[:, :1]], axis=1) if count else each
    return Path(closed.reshape(-1, 2), codes.reshape(-1))


def lines(routes: Iterable[Sequence[Point]]) -> Path:
    """Return one path with a line through the points of each route."""
    known = [route for route in routes if len(route)]
    codes = [
        Path.MOVETO if number == 0 else Path.LINETO
        for route in known
        for number in range(len(route))
    ]
    return Path(np.array([point for route in known for point in route]).reshape(-1, 2), codes)


@cache
def glyphs(text: str) -> tuple[Path, float]:
    """Return the outline of bold text of font size 1, centred at 0, 0, and its width."""
    path = TextPath((0, 0), text, size=1, prop=FontProperties(weight="bold"))
    box = path.get_extents()
    centred = Affine2D().translate(-(box.x0 + box.x1) / 2, -(box.y0 + box.y1) / 2).scale(1, -1)
    return path.transformed(centred), box.width


def written(text: str, size: float, at: ArrayLike) -> Path:
    """Return the outline of bold text centred at a position; ``size`` is in cells."""
    path, _ = glyphs(text)
    return Path(size * np.asarray(path.vertices) + np.asarray(at), path.codes)


def joined(paths: Iterable[Path]) -> Path:
    """Return one path that consists of all paths."""
    return Path.make_compound_path(*paths)


def outlined(path: Path, size: float, color: str = "paper") -> Iterator[Shape]:
    """Yield light letters with a dark line around them, or dark letters without a line."""
    if color != "ink":
        yield Shape(path, None, "ink", LOOK["lines"]["letter"] * size)
    yield Shape(path, color)
