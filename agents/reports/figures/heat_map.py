"""Heat maps of the cells where robots get stuck, one for each failure mode.

``H`` is the height of the layout and ``W`` its width, in cells.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
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

from agents.errors import StoreError
from agents.experiments.case import TILES
from agents.experiments.store import Store
from warehouse_core.records.episode import DELIVERED
from warehouse_core.records.failure_modes import MODES
from warehouse_core.render.palette import COLORS, INK, PAPER
from warehouse_core.viz.axes import draw_grid
from warehouse_core.world.tiles import DROPOFF, PICKUP, WALL, runs_of

Counts = NDArray[np.int64]
"""``[H, W]`` numbers of episodes that ended or were stuck in each cell."""

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

MIN_LETTER = 6.0

HEAT = LinearSegmentedColormap.from_list("heat", mpl.colormaps["YlOrRd"](np.linspace(0.12, 1, 64)))
"""Warm colours; those of the stations are cold. It begins darker than the floor."""

STUCK = f"""
SELECT mode, row, col, count(*) FROM episodes
WHERE case_id IN (SELECT value FROM json_each(?)) AND mode != '{DELIVERED}'
GROUP BY mode, row, col
"""


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where panels go, in inches."""

    columns: int
    lines: int
    cell: float
    grid_width: float
    grid_height: float

    @property
    def panel(self) -> tuple[float, float]:
        return max(LEFT + self.grid_width + RIGHT, MIN_PANEL), TOP + self.grid_height + BOTTOM

    @property
    def size(self) -> tuple[float, float]:
        return self.columns * self.panel[0], self.lines * self.panel[1]


def stuck_cells(store: Store, case_ids: Sequence[int]) -> dict[str, Counts]:
    """Count for each failure mode the cells where its episodes ended or were stuck.

    Args:
        store: of the results.
        case_ids: cases with the same layout.

    Returns:
        ``[H, W]`` counts by failure mode, in the order of ``MODES``.

    Raises:
        ValueError: the layout is not the same in all cases, or random for each seed.
        StoreError: an episode was stuck where there is no cell.
    """
    cases = store.cases()
    layouts = {tuple(cases[case_id].get(TILES, ())) for case_id in case_ids}
    if len(layouts) != 1 or layouts == {()}:
        raise ValueError(f"cases {list(case_ids)} have {len(layouts)} layouts; one fixed layout")
    [rows] = layouts
    found: dict[str, Counts] = {}
    for mode, row, col, count in store.query(STUCK, json.dumps(list(case_ids))):
        counts = found.setdefault(mode, np.zeros((len(rows), len(rows[0])), dtype=np.int64))
        if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
            raise StoreError(f"{store.path}: row {row}, column {col} is off the layout")
        counts[row, col] = count
    return {mode: found[mode] for mode in MODES if mode in found}


def heat_map(rows: Sequence[str], stuck: Mapping[str, Counts], episodes: int) -> Figure:
    """Return the heat maps of a layout, one panel per mode.

    Args:
        rows: of tiles.
        stuck: for each mode ``[H, W]`` counts, as ``stuck_cells`` gives them.
        episodes: the number of all episodes, deliveries included.

    Raises:
        ValueError: there is no mode to draw.
    """
    if not stuck:
        raise ValueError("stuck has no modes; at least one")
    plan = _plan(rows, len(stuck))
    width, height = plan.size
    figure = Figure(figsize=(width, height), facecolor=PAPER)
    for index, (mode, counts) in enumerate(stuck.items()):
        line, column = divmod(index, plan.columns)
        left, top = column * plan.panel[0] + LEFT, line * plan.panel[1] + TOP
        bottom = 1 - (top + plan.grid_height) / height
        tall = plan.grid_height / height
        axes = figure.add_axes((left / width, bottom, plan.grid_width / width, tall))
        count = int(counts.sum())
        title = f"{mode}: {count:,} ({count / max(episodes, 1):.1%})"
        axes.set_title(title, fontsize=9.5, loc="left", color=INK, pad=5, parse_math=False)
        heat = _draw_panel(axes, rows, counts, plan.cell * POINTS)
        left += plan.grid_width + BAR_GAP
        _draw_bar(figure.add_axes((left / width, bottom, BAR / width, tall)), heat)
    return figure


def _plan(rows: Sequence[str], panels: int) -> _Plan:
    height, width = len(rows), len(rows[0])
    columns = COLUMNS.get(panels, MAX_COLUMNS)
    if width > 30:  # wide layouts need room
        columns = min(columns, 2)
    room = WIDTH / columns - LEFT - RIGHT
    cell = min(room / width, MAX_GRID_HEIGHT / height, MAX_CELL)
    return _Plan(columns, math.ceil(panels / columns), cell, cell * width, cell * height)


def _draw_panel(
    axes: Axes, rows: Sequence[str], counts: Counts, cell_points: float
) -> PatchCollection:
    """Draw floor, heat, walls and stations, and return the heat."""
    size = len(rows), len(rows[0])
    every = 1 if max(size) <= 14 else 5 if max(size) <= 60 else 10
    thin = 0.5 if max(size) <= 30 else 0.25
    draw_grid(axes, size, every, thin, label_size=6.5, pad=1.5)
    places = np.argwhere(counts)
    heat = PatchCollection([Rectangle((col, row), 1, 1) for row, col in places], cmap=HEAT)
    heat.set_array(counts[counts > 0])
    heat.set_norm(Normalize(0, max(int(counts.max()), 1)))
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
    for tile in (PICKUP, DROPOFF):
        for row, col in _cells(rows, tile):
            _draw_station(axes, row, col, tile, cell_points)
    if cell_points >= MIN_READABLE_CELL:
        for row, col in places:
            below_letter = rows[row][col] in (PICKUP, DROPOFF)
            _write_count(axes, row, col, counts, cell_points, 0.66 if below_letter else 0.54)
    return heat


def _cells(rows: Sequence[str], tile: str) -> Iterator[tuple[int, int]]:
    for row, line in enumerate(rows):
        for col, each in enumerate(line):
            if each == tile:
                yield row, col


def _draw_station(axes: Axes, row: int, col: int, tile: str, cell_points: float) -> None:
    """Frame a station in its colour and put its letter in a corner; the heat shows inside."""
    edge = max(1.2, cell_points / 11)
    inset = edge / 2 / cell_points
    side = 1 - 2 * inset
    frame = Rectangle((col + inset, row + inset), side, side, fill=False, zorder=2)
    frame.set(edgecolor=COLORS[tile], linewidth=edge, joinstyle="miter")
    axes.add_patch(frame)
    is_large = cell_points >= MIN_READABLE_CELL
    size = max(MIN_LETTER, 0.3 * cell_points)
    place = (col + 0.15, row + 0.13) if is_large else (col + 0.5, row + 0.5)
    text = axes.text(*place, tile, fontsize=size, fontweight="bold", color=INK, zorder=3)
    if is_large:
        text.set(ha="left", va="top")
    else:  # a letter larger than its cell stands on its colour
        text.set(ha="center", va="center")
        text.set_bbox({"boxstyle": "square,pad=0.12", "facecolor": COLORS[tile], "linewidth": 0})


def _write_count(
    axes: Axes, row: int, col: int, counts: Counts, cell_points: float, down: float
) -> None:
    share = counts[row, col] / counts.max()
    digits = f"{counts[row, col]}"
    size = min(0.34, 1.25 / len(digits)) * cell_points
    color = PAPER if share > 0.6 else INK
    axes.text(
        col + 0.5, row + down, digits, fontsize=size, color=color, ha="center", va="center",
        zorder=4,
    )  # fmt: skip


def _draw_bar(axes: Axes, heat: PatchCollection) -> None:
    """Draw the colour bar of one panel, in episodes."""
    assert axes.figure is not None, "axes are of a figure"
    bar = axes.figure.colorbar(heat, cax=axes)
    bar.outline.set_visible(False)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, integer=True))
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    axes.tick_params(length=2, labelsize=6.5, labelcolor="0.45", color="0.6", pad=1.5)
