"""The warehouse itself: tiles, the robot over them, its trail and what it hits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from matplotlib.text import Text

from warehouse_core.layout import DROPOFF, EMPTY, PICKUP, WALL
from warehouse_core.palette import COLORS, FAINT, HIT, INK, TRAIL_COLORS, TRAIL_STYLES
from warehouse_core.scene_figure import SceneFigure
from warehouse_core.sight import ROBOT_EMPTY, ROBOT_LOADED
from warehouse_core.track import Hit, Pose, Rows

ROBOT_RADIUS = 0.31
"""In cells; leaves the letter in the corner of a tile readable."""

MIN_LETTER_POINTS = 6.0
MIN_ROBOT_POINTS = 5.0
"""Radius of the robot on a large grid, where a third of a cell could not be seen."""


class GridView:
    """Draws the grid of a track into its axes, in units of cells, row 0 on top.

    Args:
        figure: that the movers are added to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch, which the letters are scaled by.
        rows: the tiles to begin with.

    """

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, rows: Rows) -> None:
        self._axes = axes
        self._cell_points = cell_points
        self._tiles: list[Artist] = []
        self._rows: Rows = ()
        self._prepare_axes(len(rows), len(rows[0]))
        self._trails = {loaded: self._trail_line(loaded) for loaded in (False, True)}
        self._radius = max(ROBOT_RADIUS, MIN_ROBOT_POINTS / cell_points)
        self._disc = axes.add_patch(
            Circle((0, 0), self._radius, linewidth=max(0.5, cell_points / 22), edgecolor=INK)
        )
        self._nose = Line2D([], [], color=INK, linewidth=max(0.8, cell_points / 14))
        axes.add_line(self._nose)
        self._letter = self._text(0, 0, "", 0.42, color="white", ha="center", va="center_baseline")
        self._hits = axes.plot(
            [], [], "*", color=HIT, markeredgecolor=INK, markersize=max(9.0, 0.5 * cell_points)
        )[0]
        for mover in (*self._trails.values(), self._disc, self._nose, self._letter, self._hits):
            figure.add_mover(mover)
        self.show_tiles(rows)

    def show_tiles(self, rows: Rows) -> None:
        """Draw these tiles, unless they are the ones that stand there already."""
        if rows is self._rows:
            return
        for artist in self._tiles:
            artist.remove()
        self._rows = rows
        self._tiles = [
            self._rectangles(rows, WALL, inset=0.0),
            self._rectangles(rows, PICKUP, inset=0.06),
            self._rectangles(rows, DROPOFF, inset=0.06),
            *self._letters(rows),
        ]

    def show_robot(self, pose: Pose | None) -> None:
        """Put the robot where ``pose`` says, or nowhere."""
        for artist in (self._disc, self._nose, self._letter):
            artist.set_visible(pose is not None)
        if pose is None:
            return
        x, y = pose.at
        kind = ROBOT_LOADED if pose.loaded else ROBOT_EMPTY
        self._disc.set(center=(x, y), facecolor=COLORS[kind])
        self._letter.set(position=(x, y), text=kind, color=INK if pose.loaded else "white")
        if pose.heading is None:
            self._nose.set_data([], [])
        else:
            dx, dy = math.cos(pose.heading), math.sin(pose.heading)
            ends = (0.72 * self._radius, 1.25 * self._radius)
            self._nose.set_data([x + r * dx for r in ends], [y + r * dy for r in ends])

    def show_trail(self, poses: Sequence[Pose | None]) -> None:
        """Draw the way that the robot has come, in one line style empty and in one loaded."""
        for loaded, line in self._trails.items():
            line.set_data(*_trail_of(poses, loaded))

    def show_hits(self, hits: Sequence[Hit]) -> None:
        """Flash where the robot hit something."""
        self._hits.set_data([hit.at[0] for hit in hits], [hit.at[1] for hit in hits])

    def _prepare_axes(self, height: int, width: int) -> None:
        axes = self._axes
        axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", facecolor=COLORS[EMPTY])
        axes.spines[:].set_visible(False)
        lines = [((x, 0), (x, height)) for x in range(width + 1)]
        lines += [((0, y), (width, y)) for y in range(height + 1)]
        axes.add_collection(LineCollection(lines, colors=[FAINT], linewidths=0.6, zorder=0.5))
        every = 1 if max(height, width) <= 20 else 5 if max(height, width) <= 60 else 10
        axes.set_xticks([c + 0.5 for c in range(0, width, every)], map(str, range(0, width, every)))
        axes.set_yticks(
            [r + 0.5 for r in range(0, height, every)], map(str, range(0, height, every))
        )
        axes.tick_params(length=0, labelsize=7, labelcolor="0.45", pad=1)
        axes.xaxis.tick_top()

    def _rectangles(self, rows: Rows, tile: str, inset: float) -> PatchCollection:
        rectangles = [
            Rectangle((start + inset, row + inset), length - 2 * inset, 1 - 2 * inset)
            for row, line in enumerate(rows)
            for start, length in _runs(line, tile, whole=tile == WALL)
        ]
        color = COLORS[tile]
        # A hair of an edge and no smoothing let the walls of neighbouring rows meet with no seam.
        seam = 0.4 if tile == WALL else 0.0
        patches = PatchCollection(
            rectangles,
            facecolor=color,
            edgecolor=color,
            linewidth=seam,
            antialiased=False,
            zorder=1,
        )
        self._axes.add_collection(patches)
        return patches

    def _letters(self, rows: Rows) -> Iterator[Text]:
        for row, line in enumerate(rows):
            for col, tile in enumerate(line):
                if tile in (PICKUP, DROPOFF):
                    yield self._text(
                        col + 0.09, row + 0.08, tile, 0.24, color=INK, ha="left", va="top", zorder=2
                    )

    def _text(self, x: float, y: float, text: str, share: float, **options: Any) -> Text:
        """Add a letter as high as ``share`` of a cell."""
        size = max(MIN_LETTER_POINTS, share * self._cell_points)
        return self._axes.text(x, y, text, fontsize=size, fontweight="bold", **options)

    def _trail_line(self, loaded: bool) -> Line2D:
        line = Line2D(
            [],
            [],
            color=TRAIL_COLORS[loaded],
            linestyle=TRAIL_STYLES[loaded],
            linewidth=max(1.0, self._cell_points / 11),
        )
        self._axes.add_line(line)
        return line


def _runs(line: str, tile: str, *, whole: bool) -> Iterator[tuple[int, int]]:
    """Yield start and length of each run of ``tile``; runs of one cell unless ``whole``."""
    start = 0
    while (start := line.find(tile, start)) >= 0:
        end = start + 1
        while whole and end < len(line) and line[end] == tile:
            end += 1
        yield start, end - start
        start = end


def _trail_of(poses: Sequence[Pose | None], loaded: bool) -> tuple[list[float], list[float]]:
    """Return the points of the way made ``loaded`` or not, with NaN where it breaks off."""
    xs: list[float] = []
    ys: list[float] = []
    for before, after in pairwise(poses):
        if before is not None and after is not None and before.loaded == loaded:
            xs += [before.at[0], after.at[0]]
            ys += [before.at[1], after.at[1]]
        elif xs and not math.isnan(xs[-1]):
            xs.append(math.nan)
            ys.append(math.nan)
    return xs, ys
