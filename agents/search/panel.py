"""One search in a picture: its cells as an image, its path as a line, its counts in words."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from agents.search.trace import FRONTIER, SHADES, WAITS, SearchCourse
from warehouse_core.render.palette import COLORS, INK, PAPER, WARNING, Color
from warehouse_core.viz.axes import draw_grid
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import EMPTY, WALL, Cell

PATH: Color = WARNING

_FLOOR, _WALL, _FRONTIER, _FIRST_SHADE = range(4)
_COLORS = np.array(
    [np.round(255 * np.array(c)) for c in (COLORS[EMPTY], COLORS[WALL], FRONTIER, *SHADES)],
    dtype=np.uint8,
)

LINED_CELL = 9
"""Minimum side of a cell, in points, for lines between the cells."""

TICK_POINTS = 18
"""Minimum distance between the numbers of two rows or columns."""


class SearchPanel:
    """Draws a search into its axes, in units of cells, row 0 on top.

    All of it moves, because the image under it does. The side of a cell is in points, 1/72 inch.
    """

    def __init__(
        self, figure: SceneFigure, axes: Axes, cell_points: float, course: SearchCourse
    ) -> None:
        self._axes, self._cell_points, self._course = axes, cell_points, course
        layout = course.layout
        is_wall = np.array([list(row) for row in layout.rows]) == WALL
        self._ground = np.where(is_wall, np.uint8(_WALL), np.uint8(_FLOOR))
        has_lines = cell_points >= LINED_CELL
        size, every = (layout.height, layout.width), _numbered(layout, cell_points)
        draw_grid(axes, size, every, line_width=0.6 if has_lines else 0, zorder=2, label_size=9)
        axes.xaxis.tick_top()
        self._image = self._show_image(_COLORS[self._ground], zorder=1)
        if has_lines:
            # The walls again, over the lines; elsewhere this image is transparent.
            walls = np.zeros((*size, 4), dtype=np.uint8)
            walls[is_wall] = [*_COLORS[_WALL], 255]
            self._show_image(walls, zorder=3)
        self._path = self._draw_path()
        self._now = axes.plot(
            [], [], "D", color=WARNING, markeredgecolor=INK, markersize=max(5.0, cell_points / 3),
            zorder=5,
        )[0]  # fmt: skip
        for name, cell in zip("SG", course.ends, strict=True):
            self._draw_end(name, cell)
        artists: list[Any] = [*axes.images, *axes.collections, *axes.lines, *axes.texts]
        name = self._draw_text(course.name, 34, fontsize=13, fontweight="bold")
        artists.sort(key=lambda artist: artist.get_zorder())
        self._counts = self._draw_text("", 17, fontsize=11)
        for artist in (*artists, name, self._counts):
            figure.add_mover(artist)

    def show(self, count: int) -> None:
        """Show the search after ``count`` expansions, or at its end if it has fewer."""
        course, solution = self._course, self._course.solution
        marks = course.marks_after(count)
        codes = self._ground.copy()
        codes[marks == WAITS] = _FRONTIER
        is_expanded = marks > 0
        codes[is_expanded] = _FIRST_SHADE + course.shades(marks[is_expanded])
        self._image.set_data(_COLORS[codes])
        is_over = course.is_over(count)
        self._path.set_visible(is_over and solution.found)
        now = course.expanded_by(count)
        at = [] if now is None else [now]
        self._now.set_data([col + 0.5 for _, col in at], [row + 0.5 for row, _ in at])
        self._counts.set_text("   ".join(course.words_after(count)))
        self._counts.set_fontweight("bold" if is_over else "normal")

    def _show_image(self, picture: NDArray[np.uint8], zorder: float) -> Any:
        height, width = picture.shape[:2]
        # Smoothing keeps cells smaller than a pixel visible; larger ones have sharp edges.
        smooth = "nearest" if self._cell_points >= 0.7 else "antialiased"
        return self._axes.imshow(
            picture,
            extent=(0, width, height, 0),
            aspect="auto",
            interpolation=smooth,
            zorder=zorder,
        )

    def _draw_path(self) -> Line2D:
        states = self._course.solution.states
        width = max(1.4, self._cell_points / 5)
        return self._axes.plot(
            [col + 0.5 for _, col in states], [row + 0.5 for row, _ in states], color=PATH,
            linewidth=width, zorder=4, solid_capstyle="round", solid_joinstyle="round",
            path_effects=[withStroke(linewidth=width + 1.6, foreground=PAPER)],
        )[0]  # fmt: skip

    def _draw_end(self, name: str, cell: Cell) -> None:
        """Draw the letter of the start or the goal on a disc, not too small to be read."""
        row, col = cell
        size = max(13.0, 0.85 * self._cell_points)
        self._axes.plot(
            [col + 0.5], [row + 0.5], "o", color=PAPER, markeredgecolor=INK, markersize=size,
            zorder=6, clip_on=False,
        )  # fmt: skip
        self._axes.text(
            col + 0.5, row + 0.5, name, fontsize=0.68 * size, fontweight="bold", color=INK,
            ha="center", va="center_baseline", zorder=7,
        )  # fmt: skip

    def _draw_text(self, text: str, above: float, **options: Any) -> Any:
        return self._axes.annotate(
            text, (0, 1), (0, above), xycoords="axes fraction", textcoords="offset points",
            parse_math=False, color=INK, annotation_clip=False, **options,
        )  # fmt: skip


def _numbered(layout: Layout, cell_points: float) -> int:
    """Return the rows or columns from one number to the next, as close as there is room."""
    steps = (power * step for power in (1, 10, 100, 1000, 10_000) for step in (1, 5))
    most = max(layout.height, layout.width)
    return next((step for step in steps if step * cell_points >= TICK_POINTS), most)
