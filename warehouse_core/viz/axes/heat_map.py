"""Heat maps of layouts, which show how often something happened in each cell.

``H`` is the height of the layout and ``W`` its width, in cells.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import EngFormatter, MaxNLocator
from numpy.typing import NDArray

from warehouse_core.records.episode import FleetEpisode
from warehouse_core.records.held_up import held_up
from warehouse_core.render.palette import COLORS, INK, PALETTE, PAPER, SHELF, Color
from warehouse_core.viz.axes import POINTS, box_in, draw_grid
from warehouse_core.world.tiles import DROPOFF, PICKUP, WALL, runs_of

CellCounts = NDArray[np.int64]
"""``[H, W]`` counts of the events in each cell."""

WIDTH = 9.6
"""Default width of a figure, in inches; a width must be at least ``MIN_PANEL``."""

MAX_GRID_HEIGHT, MAX_CELL = 4.6, 0.5
LEFT, RIGHT, TOP, BOTTOM = 0.36, 0.72, 0.5, 0.34
"""Space around the grid of a panel, in inches, for its numbers, its colour bar and its title."""
MIN_PANEL = 3.3
"""Smallest width of a panel, in inches: enough for the longest title with the largest numbers."""
BAR, BAR_GAP = 0.11, 0.09

PANEL, MAX_PANEL_CELL, SPACE = 6.2, 0.4, 0.55
"""Width of a panel of congestion, largest side of its cells, and space around it, in inches."""

HEAD, PANEL_HEAD, FOOT, WIDE_BAR = 0.95, 0.6, 1.35, 0.22
TITLE, WORDS, SMALL = 23, 25, 15
"""Font sizes of congestion in points, large enough for a picture that is shown to a class."""

AnyFigure = TypeVar("AnyFigure", bound=Figure)

TITLE_SIZE, MIN_SIZE = 11.0, 9.0
"""Font sizes in points, of titles and of the smallest text; 9 points are 12 CSS pixels. Counts that
would have to be smaller are left out."""

STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 5_000, 10_000, 100_000, 1_000_000)
"""Possible distances, in cells, between two labelled rows or columns."""

TICK_ROOM = 21.0
"""Least distance, in points, between the labels of two rows or columns."""

HEAT = LinearSegmentedColormap.from_list("heat", PALETTE["heat"]["light"], N=32)
"""Colours of counts, all darker than the floor."""

MAX_LIGHT_HEAT = 0.6
"""Share of the highest count up to which numbers are dark; above it they are light."""


def heat_map(
    rows: Sequence[str],
    panels: Mapping[str, CellCounts],
    *,
    width: float = WIDTH,
    with_stations: bool = False,
) -> Figure:
    """Return a figure with heat maps of a layout.

    Args:
        rows: rows of the layout.
        panels: ``[H, W]`` counts of each panel, by its title.
        width: width of the figure in inches.
        with_stations: mark pickups and dropoffs.
    """
    columns = min(len(panels), int(width // MIN_PANEL))
    room = width / columns - LEFT - RIGHT
    cell = min(room / len(rows[0]), MAX_GRID_HEIGHT / len(rows), MAX_CELL)
    grid_width, grid_height = cell * len(rows[0]), cell * len(rows)
    panel_width = max(LEFT + grid_width + RIGHT, MIN_PANEL)
    panel_height = TOP + grid_height + BOTTOM
    size = columns * panel_width, math.ceil(len(panels) / columns) * panel_height
    figure = Figure(figsize=size, facecolor=PAPER)
    for index, (title, counts) in enumerate(panels.items()):
        line, column = divmod(index, columns)
        left, top = column * panel_width + LEFT, line * panel_height + TOP
        axes = figure.add_axes(box_in(size, left, top, grid_width, grid_height))
        axes.set_title(title, fontsize=TITLE_SIZE, loc="left", color=INK, pad=6, parse_math=False)
        heat = draw_heat(axes, rows, counts, cell * POINTS, max(int(counts.max()), 1))
        if with_stations:
            _mark_stations(axes, rows, cell * POINTS)
        left += grid_width + BAR_GAP
        _draw_bar(figure.add_axes(box_in(size, left, top, BAR, grid_height)), heat)
    return figure


def draw_heat(
    axes: Axes,
    rows: Sequence[str],
    counts: CellCounts,
    cell_points: float,
    highest: int,
    *,
    digits: bool = True,
) -> PatchCollection:
    """Draw floor, heat and walls, and return the heat.

    The hottest colour stands for the count ``highest``. With ``digits`` the counts are written into
    the cells, whose side has ``cell_points`` points, if they are large enough.
    """
    longest = max(len(rows), len(rows[0]))
    every = next(step for step in STEPS if step * cell_points >= TICK_ROOM)
    thin = 0.5 if longest <= 30 else 0.25
    draw_grid(axes, (len(rows), len(rows[0])), every, thin, label_size=MIN_SIZE, pad=1.5)
    axes.tick_params(labelcolor=INK)
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
    wall: dict[str, Any] = {"facecolor": SHELF, "edgecolor": SHELF}
    axes.add_collection(PatchCollection(walls, linewidth=0.4, antialiased=False, **wall))
    size = min(0.42, 1.45 / len(f"{counts.max()}")) * cell_points
    if digits and size >= MIN_SIZE:
        for row, col in places:
            number = f"{counts[row, col]}"
            color = ink_of_heat(counts[row, col] / highest)
            axes.text(
                col + 0.5, row + 0.54, number, fontsize=size, color=color, ha="center",
                va="center", zorder=4,
            )  # fmt: skip
    return heat


def ink_of_heat(share: float) -> Color:
    """Return the text colour for a number in a cell that has this share of the highest count."""
    return PAPER if share > MAX_LIGHT_HEAT else INK


def _mark_stations(axes: Axes, rows: Sequence[str], cell_points: float) -> None:
    """Draw a frame around each station in its colour, with its letter at the top edge."""
    wide = min(2.5, cell_points / 4)
    for row, line in enumerate(rows):
        for col, tile in enumerate(line):
            if tile in (PICKUP, DROPOFF):
                frame: dict[str, Any] = {"edgecolor": COLORS[tile], "linewidth": wide, "zorder": 3}
                axes.add_patch(Rectangle((col, row), 1, 1, fill=False, **frame))
                axes.text(
                    col + 0.5, row, tile, fontsize=MIN_SIZE, fontweight="bold", color="black",
                    ha="center", va="center_baseline", zorder=5,
                    bbox={"boxstyle": "round,pad=0.2", "facecolor": COLORS[tile], "linewidth": 0},
                )  # fmt: skip


def _draw_bar(axes: Axes, heat: PatchCollection) -> None:
    """Draw the colour bar of one panel."""
    assert axes.figure is not None, "the axes belong to a figure"
    bar = axes.figure.colorbar(heat, cax=axes)
    bar.outline.set_visible(False)
    assert bar.solids is not None, "the colour bar of a collection has solids"
    bar.solids.set_edgecolor("face")
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, integer=True))
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    axes.tick_params(length=2, labelsize=MIN_SIZE, labelcolor=INK, color=INK, pad=1.5)


def held_up_cells(episode: FleetEpisode) -> CellCounts:
    """Return how often robots were held up in each cell, ``[H, W]``; see ``held_up``."""
    layout, held = episode.layout, held_up(episode)
    size = layout.height * layout.width
    return np.bincount(episode.cells[:-1][held], minlength=size).reshape(
        layout.height, layout.width
    )


def congestion_picture(
    episodes: Mapping[str, FleetEpisode],
    title: str,
    make_figure: Callable[[tuple[float, float]], AnyFigure],
) -> AnyFigure:
    """Return heat maps of where robots were held up, with a common scale and the throughputs.

    Args:
        episodes: record of each panel, by its title; all layouts must have the same size.
        title: title of the picture.
        make_figure: function that returns a figure of a given width and height in inches.
    """
    panels = {name: held_up_cells(episode) for name, episode in episodes.items()}
    highest = max(int(counts.max()) for counts in panels.values())
    height, width = next(iter(panels.values())).shape
    cell = min(PANEL / max(height, width), MAX_PANEL_CELL)
    wide, high = cell * width, cell * height
    bar_left = SPACE + len(panels) * (wide + SPACE)
    size = bar_left + WIDE_BAR + 1.1, HEAD + PANEL_HEAD + high + FOOT
    figure = make_figure(size)
    figure.set_facecolor(PAPER)
    style: dict[str, Any] = {"color": INK, "parse_math": False, "va": "center"}

    def write(left: float, top: float, words: str, **options: Any) -> None:
        figure.text(left / size[0], 1 - top / size[1], words, **style, **options)

    write(SPACE, HEAD / 2, title, fontsize=TITLE, fontweight="bold")
    top = HEAD + PANEL_HEAD
    for number, (name, counts) in enumerate(panels.items()):
        left, episode = SPACE + number * (wide + SPACE), episodes[name]
        axes = figure.add_axes(box_in(size, left, top, wide, high))
        heat = draw_heat(axes, episode.layout.rows, counts, cell * POINTS, highest, digits=False)
        axes.tick_params(labelsize=10)
        share = counts.sum() / max(episode.cells[:-1].size, 1)
        write(left, HEAD + 0.25, name, fontsize=TITLE)
        verdict = f"{episode.measures.per_hour:,.0f} deliveries per hour"
        write(left, top + high + 0.55, verdict, fontsize=WORDS, fontweight="bold")
        words = f"robots held up in {share:.0%} of their steps"
        write(left, top + high + 1.0, words, fontsize=SMALL)
    axes = figure.add_axes(box_in(size, bar_left, top, WIDE_BAR, high))
    figure.colorbar(heat, cax=axes).outline.set_visible(False)
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    axes.tick_params(length=2, labelsize=SMALL, labelcolor=INK)
    axes.set_ylabel("times robots were held up in a cell", fontsize=SMALL, color=INK)
    return figure
