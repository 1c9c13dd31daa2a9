"""The style of axes that show a layout or a chart."""

from __future__ import annotations

from typing import Literal

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from warehouse_core.render.palette import COLORS, FAINT
from warehouse_core.world.tiles import EMPTY

POINTS = 72
"""Points in an inch."""

SMALLEST = 8.5
"""Size of the smallest text, in points: at least 11 CSS pixels."""


def draw_grid(
    axes: Axes,
    size: tuple[int, int],
    every: int,
    line_width: float,
    *,
    label_size: float = SMALLEST,
    pad: float = 1.0,
) -> None:
    """Prepare axes for a layout of ``size`` rows and columns, in units of cells, row 0 on top.

    Every row and column whose number is a multiple of ``every`` is labelled. The size of the labels
    (``label_size``), their distance from the grid (``pad``) and the width of the lines between
    cells are in points. A line width of 0 draws no lines.
    """
    height, width = size
    axes.set(xlim=(0, width), ylim=(height, 0), facecolor=COLORS[EMPTY])
    axes.spines[:].set_visible(False)
    if line_width:
        lines = [((x, 0), (x, height)) for x in range(width + 1)]
        lines += [((0, y), (width, y)) for y in range(height + 1)]
        axes.add_collection(
            LineCollection(lines, colors=[FAINT], linewidths=line_width, zorder=0.5)
        )
    for axis, count in ((axes.xaxis, width), (axes.yaxis, height)):
        numbers = range(0, count, every)
        axis.set_ticks([number + 0.5 for number in numbers], list(map(str, numbers)))
    axes.tick_params(length=0, labelsize=label_size, labelcolor="0.45", pad=pad)


def box_in(
    size: tuple[float, float], left: float, top: float, width: float, height: float
) -> tuple[float, float, float, float]:
    """Return a box, given from the top left corner, in the format of ``Figure.add_axes``."""
    whole_width, whole_height = size
    return (
        left / whole_width,
        1 - (top + height) / whole_height,
        width / whole_width,
        height / whole_height,
    )


def style_chart(axes: Axes, lines: Literal["both", "x", "y"] = "both") -> None:
    """Style a chart: no frame at the top and right, small numbers, and faint grid lines."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=SMALLEST)
    axes.grid(axis=lines, color=FAINT, linewidth=0.5)
    axes.set_axisbelow(True)
