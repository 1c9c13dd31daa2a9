"""Heat maps of a layout: how often something happened in each cell.

``H`` is the height of the layout and ``W`` its width, in cells.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import EngFormatter, MaxNLocator
from numpy.typing import NDArray

from warehouse_core.motion.vector import NOTHING
from warehouse_core.motion.vector import WALL as WALL_STOPS
from warehouse_core.records.fleet_episode import FleetEpisode
from warehouse_core.render.palette import COLORS, INK, PAPER
from warehouse_core.viz.axes.look import draw_grid
from warehouse_core.wording import counted
from warehouse_core.world.tiles import WALL, runs_of

Counts = NDArray[np.int64]
"""``[H, W]`` numbers of what happened in each cell."""

WIDTH = 9.6
"""Of a figure, in inches."""

COLUMNS = {1: 1, 2: 2, 4: 2}
"""Columns of panels by the number of panels; ``MAX_COLUMNS`` for others."""
MAX_COLUMNS = 3

MAX_GRID_HEIGHT, MAX_CELL = 4.6, 0.5
LEFT, RIGHT, TOP, BOTTOM = 0.3, 0.62, 0.42, 0.28
"""Around the grid of each panel, in inches, for its numbers, its colour bar and its title."""
MIN_PANEL = 2.9
"""Enough for the longest title with the largest numbers."""
BAR, BAR_GAP = 0.11, 0.09

POINTS = 72
"""Per inch."""

MIN_READABLE_CELL = 19.0
"""Points; the numbers of smaller cells are not written."""

HEAT = LinearSegmentedColormap.from_list("heat", mpl.colormaps["YlOrRd"](np.linspace(0.12, 1, 64)))
"""It begins darker than the floor."""

BLOCKED = ("wall", "robot", "person")
"""What blocks a move."""


def blocked_cells(episode: FleetEpisode) -> dict[str, Counts]:
    """Count for each of ``BLOCKED`` how often it blocked a move, by the cell of the robot."""
    layout, robots = episode.layout, episode.robots
    by, cells = episode.stopped_by, episode.cells[:-1]
    masks = (by == WALL_STOPS, (by > NOTHING) & (by < robots), by >= robots)
    size = layout.height * layout.width
    return {
        name: np.bincount(cells[mask], minlength=size).reshape(layout.height, layout.width)
        for name, mask in zip(BLOCKED, masks, strict=True)
    }


def blocked_heat_map(episode: FleetEpisode) -> Figure:
    """Return heat maps of where the robots of a fleet were blocked, one for each of ``BLOCKED``."""
    found = blocked_cells(episode)
    panels = {
        f"blocked by a {name}: {counted(int(counts.sum()), 'move')}": counts
        for name, counts in found.items()
        if counts.any() or name == "robot"
    }
    return heat_map(episode.layout.rows, panels)


def heat_map(rows: Sequence[str], panels: Mapping[str, Counts]) -> Figure:
    """Return the heat maps of a layout without its stations.

    Args:
        rows: of tiles.
        panels: ``[H, W]`` counts by title; at least one.
    """
    columns = COLUMNS.get(len(panels), MAX_COLUMNS)
    if len(rows[0]) > 30:  # wide layouts need room
        columns = min(columns, 2)
    room = WIDTH / columns - LEFT - RIGHT
    cell = min(room / len(rows[0]), MAX_GRID_HEIGHT / len(rows), MAX_CELL)
    grid_width, grid_height = cell * len(rows[0]), cell * len(rows)
    panel_width = max(LEFT + grid_width + RIGHT, MIN_PANEL)
    panel_height = TOP + grid_height + BOTTOM
    width, height = columns * panel_width, math.ceil(len(panels) / columns) * panel_height
    figure = Figure(figsize=(width, height), facecolor=PAPER)
    for index, (title, counts) in enumerate(panels.items()):
        line, column = divmod(index, columns)
        left, top = column * panel_width + LEFT, line * panel_height + TOP
        bottom, tall = 1 - (top + grid_height) / height, grid_height / height
        axes = figure.add_axes((left / width, bottom, grid_width / width, tall))
        axes.set_title(title, fontsize=9.5, loc="left", color=INK, pad=5, parse_math=False)
        heat = draw_heat(axes, rows, counts, cell * POINTS, max(int(counts.max()), 1))
        left += grid_width + BAR_GAP
        _draw_bar(figure.add_axes((left / width, bottom, BAR / width, tall)), heat)
    return figure


def draw_heat(
    axes: Axes,
    rows: Sequence[str],
    counts: Counts,
    cell_points: float,
    highest: int,
    *,
    digits: bool = True,
) -> PatchCollection:
    """Draw floor, heat and walls, and return the heat.

    Args:
        axes: to draw into.
        rows: of tiles.
        counts: ``[H, W]``.
        cell_points: side of a cell in points.
        highest: the count of the hottest colour.
        digits: write the counts into cells that are large enough.
    """
    longest = max(len(rows), len(rows[0]))
    every = 1 if longest <= 14 else 5 if longest <= 60 else 10
    thin = 0.5 if longest <= 30 else 0.25
    draw_grid(axes, (len(rows), len(rows[0])), every, thin, label_size=6.5, pad=1.5)
    places = np.argwhere(counts)
    heat = PatchCollection([Rectangle((col, row), 1, 1) for row, col in places], cmap=HEAT)
    heat.set_array(counts[counts > 0])
    heat.set_norm(Normalize(0, highest))
    heat.set(edgecolor=PAPER, linewidth=min(0.4, cell_points / 20), zorder=1)
    axes.add_collection(heat)
    walls = [
        Rectangle((left, row), right - left, 1)
        for row, line in enumerate(rows)
        for left, right in runs_of(WALL, line)
    ]
    # A thin edge and no smoothing leave no seam between the walls of neighbouring rows.
    wall: dict[str, Any] = {"facecolor": COLORS[WALL], "edgecolor": COLORS[WALL]}
    axes.add_collection(PatchCollection(walls, linewidth=0.4, antialiased=False, **wall))
    if digits and cell_points >= MIN_READABLE_CELL:
        for row, col in places:
            number = f"{counts[row, col]}"
            size = min(0.34, 1.25 / len(number)) * cell_points
            color = PAPER if counts[row, col] / highest > 0.6 else INK
            axes.text(
                col + 0.5, row + 0.54, number, fontsize=size, color=color, ha="center",
                va="center", zorder=4,
            )  # fmt: skip
    return heat


def _draw_bar(axes: Axes, heat: PatchCollection) -> None:
    """Draw the colour bar of one panel."""
    assert axes.figure is not None, "axes are of a figure"
    bar = axes.figure.colorbar(heat, cax=axes)
    bar.outline.set_visible(False)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, integer=True))
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    axes.tick_params(length=2, labelsize=6.5, labelcolor="0.45", color="0.6", pad=1.5)
