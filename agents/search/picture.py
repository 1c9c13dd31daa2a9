"""An animated search, or several side by side from the same start to the same goal.

The cells of a search are an image, its path is a line, and its counts are words.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import offset_copy
from numpy.typing import NDArray

from agents.search.trace import (
    FRONTIER,
    MAX_PANELS,
    SHADES,
    WAITS,
    SearchCourse,
    track_of_course,
)
from warehouse_core.render.palette import COLORS, INK, PAPER, SHELF, WARNING, Color
from warehouse_core.viz.axes import box_in, draw_grid
from warehouse_core.viz.figure import DPI, SceneFigure, make_figure, make_window
from warehouse_core.viz.replay import Replay
from warehouse_core.wording import printable
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import EMPTY, WALL, Cell

MAX_FRAMES = 120
"""Most frames of an animation, the first and the last included."""

FRAME_MS = 100.0

# In pixels, because cells of a whole number of pixels have sharp edges.
MAX_SIZE = (1366, 860)
MARGIN, HEAD, FOOT = 24, 76, 52
PANEL_LEFT, PANEL_HEAD, PANEL_FOOT = 20, 68, 12
MIN_WIDTH = 940  # for the title and the legend
MIN_PANEL, MAX_CELL, GOOD_CELL = 340, 40, 28

PATH: Color = WARNING

_FLOOR, _WALL, _FRONTIER, _FIRST_SHADE = range(4)
_COLORS = np.array(
    [np.round(255 * np.array(c)) for c in (COLORS[EMPTY], SHELF, FRONTIER, *SHADES)],
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
        self._figure = figure
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
        self._write(34, fontsize=13, fontweight="bold").set_text(course.name)
        artists.sort(key=lambda artist: artist.get_zorder())
        self._counts = self._write(17, fontsize=11)
        for artist in (*artists, self._counts):
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

    def _write(self, above: float, **options: Any) -> Text:
        """Add words, none so far, so many points above the axes.

        They are of the figure, which does not draw what axes have so far outside of them again.
        """
        place = offset_copy(self._axes.transAxes, self._figure, 0, above, units="points")
        return self._figure.text(0, 1, "", transform=place, parse_math=False, color=INK, **options)


class _Arrangement:
    """Sizes and places of panels in so many columns, in pixels."""

    def __init__(self, layout: Layout, panels: int, columns: int) -> None:
        self.columns, rows = columns, math.ceil(panels / columns)
        wide = (MAX_SIZE[0] - MARGIN) / columns - MARGIN - PANEL_LEFT
        high = (MAX_SIZE[1] - HEAD - FOOT) / rows - PANEL_HEAD - PANEL_FOOT
        cell = min(wide / layout.width, high / layout.height, MAX_CELL)
        cell = math.floor(cell) if cell >= 1 else cell
        if columns > 1 and wide < MIN_PANEL:
            cell = 0.0  # the words above a panel would overlap those of the next
        self.cell, self.places = cell, columns * rows
        self.step_right = PANEL_LEFT + max(cell * layout.width, MIN_PANEL) + MARGIN
        self.step_down = PANEL_HEAD + cell * layout.height + PANEL_FOOT
        self.width = max(MIN_WIDTH, MARGIN + columns * self.step_right)
        self.height = HEAD + rows * self.step_down + FOOT


class _SearchScene:
    """Searches side by side in one figure, expansion by expansion."""

    def __init__(self, courses: Sequence[SearchCourse], title: str, window: bool) -> None:
        self._longest, layout = max(map(len, courses)), courses[0].layout
        self._each = max(1, math.ceil(self._longest / (MAX_FRAMES - 1)))
        arrangement = _arranged(layout, len(courses))
        width, height = arrangement.width, arrangement.height
        size = width / DPI, height / DPI
        self.root = (make_window if window else make_figure)(size)
        self._panels = []
        for place, course in enumerate(courses):
            row, column = divmod(place, arrangement.columns)
            left = MARGIN + PANEL_LEFT + column * arrangement.step_right
            top = HEAD + PANEL_HEAD + row * arrangement.step_down
            drawn = layout.width * arrangement.cell, layout.height * arrangement.cell
            axes = self.root.add_axes(box_in((width, height), left, top, *drawn))
            points = arrangement.cell * 72 / DPI
            self._panels.append(SearchPanel(self.root, axes, points, course))
        common: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        left, top = MARGIN / width, 1 - 24 / height
        self.root.text(left, top, printable(title), fontsize=14, fontweight="bold", **common)
        self._counter = self.root.text(left, 1 - 54 / height, "", fontsize=12, **common)
        self.root.add_mover(self._counter)
        draw_search_legend(self.root)
        self.show(0)

    def __len__(self) -> int:
        return math.ceil(self._longest / self._each) + 1

    @property
    def still(self) -> int:
        """The frame of a picture that does not move: the last."""
        return len(self) - 1

    def show(self, frame: int) -> None:
        """Show all searches after the same number of expansions."""
        count = min(frame * self._each, self._longest)
        for panel in self._panels:
            panel.show(count)
        self._counter.set_text(f"after {count} of {self._longest} expansions")


def search_replay(courses: Sequence[SearchCourse], title: str, *, window: bool = False) -> Replay:
    """Return the animation of searches on one layout, side by side under a title.

    Raises:
        ValueError: no search, or more than ``MAX_PANELS``.
    """
    if not 1 <= len(courses) <= MAX_PANELS:
        raise ValueError(f"{len(courses)} searches; there must be 1..{MAX_PANELS}")
    scene = _SearchScene(courses, title, window)
    return Replay(scene, [track_of_course(course) for course in courses], FRAME_MS)


def draw_search_legend(figure: SceneFigure) -> None:
    """Draw the legend along the bottom."""
    square: dict[str, Any] = {"marker": "s", "markersize": 12, "linestyle": "none", "mec": INK}
    disc = Line2D([], [], color=PAPER, **(square | {"marker": "o", "markersize": 17}))
    letter: dict[str, Any] = {"markersize": 9, "linestyle": "none", "color": INK, "mew": 0.6}
    signs: dict[str, Any] = {
        "start": (disc, Line2D([], [], marker="$\\mathbf{S}$", **letter)),
        "goal": (disc, Line2D([], [], marker="$\\mathbf{G}$", **letter)),
        "wall": Line2D([], [], color=SHELF, **square),
        "expanded first": Line2D([], [], color=SHADES[0], **square),
        "expanded last": Line2D([], [], color=SHADES[-1], **square),
        "frontier": Line2D([], [], color=FRONTIER, **square),
        "expanded now": Line2D([], [], color=WARNING, **(square | {"marker": "D"})),
        "path": Line2D([], [], color=PATH, linewidth=3.5),
    }
    figure.legend(
        [*signs.values()], [*signs], loc="lower left", ncols=len(signs), fontsize=11,
        frameon=False, handlelength=1.4, columnspacing=1.1, handletextpad=0.4,
        bbox_to_anchor=(0.01, 0.0),
    )  # fmt: skip


def _arranged(layout: Layout, panels: int) -> _Arrangement:
    """Return panels in one row if their cells are large enough, or with the largest cells."""
    all_columns = range(panels, 0, -1)
    one_row, *others = (_Arrangement(layout, panels, columns) for columns in all_columns)
    if one_row.cell >= GOOD_CELL:
        return one_row
    # Among equally large cells, the fewest empty places.
    return max([one_row, *others], key=lambda each: (each.cell, -each.places))


def _numbered(layout: Layout, cell_points: float) -> int:
    """Return the rows or columns from one number to the next, as close as there is room."""
    steps = (power * step for power in (1, 10, 100, 1000, 10_000) for step in (1, 5))
    most = max(layout.height, layout.width)
    return next((step for step in steps if step * cell_points >= TICK_POINTS), most)
