"""One search in a picture: its cells as an image, its path as a line, and what it came to."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from agents.search.trace import WAITS, SearchCourse
from warehouse_core.render.palette import COLORS, FAINT, HIT, INK, PAPER, WARNING, Color, blend
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import EMPTY, PICKUP, WALL, Cell

# Of the palette of a replay's files, for the most part: they know no other colours.
SHADES: tuple[Color, ...] = tuple(
    blend(COLORS[PICKUP], COLORS[EMPTY], share) for share in (0.75, 0.5, 0.25, 0.0)
)
"""Of the cells that are expanded: the first quarter, and so on."""

FRONTIER: Color = HIT
PATH: Color = WARNING

_FLOOR, _WALL, _FRONTIER, _FIRST_SHADE = range(4)
_COLORS = np.array(
    [np.round(255 * np.array(c)) for c in (COLORS[EMPTY], COLORS[WALL], FRONTIER, *SHADES)],
    dtype=np.uint8,
)

LINED_CELL = 9
"""Points from which on the lines between the cells are drawn."""

TICK_POINTS = 18
"""The least that the numbers of two rows or columns are apart."""


class SearchPanel:
    """Draws a search into its axes, in units of cells, row 0 on top.

    Args:
        figure: that everything is added to; all of it moves, as it lies on an image that does.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
        layout: that is searched.
        ends: the start and the goal.
        course: what the search does.
    """

    def __init__(
        self,
        figure: SceneFigure,
        axes: Axes,
        cell_points: float,
        layout: Layout,
        ends: tuple[Cell, Cell],
        course: SearchCourse,
    ) -> None:
        self._axes, self._cell_points, self._course = axes, cell_points, course
        is_wall = np.array([list(row) for row in layout.rows]) == WALL
        self._ground = np.where(is_wall, np.uint8(_WALL), np.uint8(_FLOOR))
        prepare_axes(axes, layout, cell_points)
        self._image = self._show_image(_COLORS[self._ground], zorder=1)
        if cell_points >= LINED_CELL:
            self._draw_lines(is_wall)
        self._path = self._draw_path()
        self._now = axes.plot(
            [], [], "D", color=WARNING, markeredgecolor=INK, markersize=max(5.0, cell_points / 3),
            zorder=5,
        )[0]  # fmt: skip
        for name, cell in zip("SG", ends, strict=True):
            self._draw_end(name, cell)
        self._made_of: Any = [*axes.images, *axes.collections, *axes.lines, *axes.texts]
        self._made_of.sort(key=lambda artist: artist.get_zorder())
        self._name = self._draw_text(course.name, 26, fontsize=10, fontweight="bold")
        self._counts = self._draw_text("", 14, fontsize=8.5)
        for artist in (*self._made_of, self._name, self._counts):
            figure.add_mover(artist)

    def show(self, count: int) -> None:
        """Show the search after ``count`` expansions, or at its end where it has fewer."""
        course, solution = self._course, self._course.solution
        marks = course.marks_after(count)
        self._image.set_data(self._picture_of(marks))
        is_over = course.is_over(count)
        self._path.set_visible(is_over and solution.found)
        now = course.expanded_by(count)
        self._now.set_data(
            [] if now is None else [now[1] + 0.5], [] if now is None else [now[0] + 0.5]
        )
        counts = f"expanded {min(count, len(course))}   frontier {int((marks == WAITS).sum())}"
        if is_over:
            counts += f"   cost {solution.cost:g}" if solution.found else "   no path"
        self._counts.set_text(counts)
        self._counts.set_fontweight("bold" if is_over else "normal")

    def _picture_of(self, marks: NDArray[np.int32]) -> NDArray[np.uint8]:
        codes = self._ground.copy()
        codes[marks == WAITS] = _FRONTIER
        is_expanded = marks > 0
        parts = (marks[is_expanded] - 1) * len(SHADES) // max(len(self._course), 1)
        codes[is_expanded] = _FIRST_SHADE + parts
        picture: NDArray[np.uint8] = _COLORS[codes]
        return picture

    def _show_image(self, picture: NDArray[np.uint8], zorder: float) -> Any:
        height, width = picture.shape[:2]
        # Of cells smaller than a pixel none is to get lost, of others every edge is to be sharp.
        smooth = "nearest" if self._cell_points >= 0.7 else "antialiased"
        return self._axes.imshow(
            picture,
            extent=(0, width, height, 0),
            aspect="auto",
            interpolation=smooth,
            zorder=zorder,
        )

    def _draw_lines(self, is_wall: NDArray[np.bool_]) -> None:
        height, width = is_wall.shape
        lines = [((x, 0), (x, height)) for x in range(width + 1)]
        lines += [((0, y), (width, y)) for y in range(height + 1)]
        self._axes.add_collection(LineCollection(lines, colors=[FAINT], linewidths=0.6, zorder=2))
        # Walls go over the lines; elsewhere this image lets everything through.
        walls = np.zeros((height, width, 4), dtype=np.uint8)
        walls[is_wall] = [*_COLORS[_WALL], 255]
        self._show_image(walls, zorder=3)

    def _draw_path(self) -> Line2D:
        states = self._course.solution.states
        width = max(1.4, self._cell_points / 5)
        return self._axes.plot(
            [col + 0.5 for _, col in states], [row + 0.5 for row, _ in states], color=PATH,
            linewidth=width, zorder=4, solid_capstyle="round", solid_joinstyle="round",
            path_effects=[withStroke(linewidth=width + 1.6, foreground=PAPER)],
        )[0]  # fmt: skip

    def _draw_end(self, name: str, cell: Cell) -> None:
        """Draw the letter of the start or the goal, on a disk, as large as can still be read."""
        row, col = cell
        size = max(10.0, 0.72 * self._cell_points)
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


def prepare_axes(axes: Axes, layout: Layout, cell_points: float) -> None:
    """Number the rows and columns of a layout along its axes, as many as there is room for."""
    height, width = layout.height, layout.width
    steps = (power * step for power in (1, 10, 100, 1000, 10_000) for step in (1, 5))
    every = next((step for step in steps if step * cell_points >= TICK_POINTS), max(height, width))
    axes.set(xlim=(0, width), ylim=(height, 0), aspect="auto", facecolor=COLORS[EMPTY])
    axes.spines[:].set_visible(False)
    axes.set_xticks([c + 0.5 for c in range(0, width, every)], map(str, range(0, width, every)))
    axes.set_yticks([r + 0.5 for r in range(0, height, every)], map(str, range(0, height, every)))
    axes.tick_params(length=0, labelsize=7, labelcolor="0.45", pad=1)
    axes.xaxis.tick_top()
