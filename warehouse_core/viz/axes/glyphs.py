"""Letters as shapes, which are drawn faster than text and scale with the axes."""

from __future__ import annotations

from functools import cache

from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D


@cache
def _outline(text: str) -> Path:
    return TextPath((0, 0), text, size=1, prop=FontProperties(weight="bold"))


def letter_path(
    text: str,
    size: float,
    at: tuple[float, float] = (0.0, 0.0),
    anchor: tuple[float, float] = (0.5, 0.5),
) -> Path:
    """Return the outline of bold text in axes whose y axis points down, at a place.

    The place is the ``anchor``, a share of the width and of the height from the top left corner.
    ``size`` is the font size in the unit of the axes.
    """
    path = _outline(text)
    (left, bottom), (right, top) = path.get_extents().get_points()
    x, y = left + anchor[0] * (right - left), top - anchor[1] * (top - bottom)
    return path.transformed(Affine2D().translate(-x, -y).scale(size, -size).translate(*at))
