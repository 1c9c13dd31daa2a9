"""An animated search, or several side by side from the same start to the same goal.

The cells of a search are an image, its path is a line, and its counts are words.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from agents.search.trace import (
    FRONTIER,
    MARK_COLORS,
    MAX_PANELS,
    SHADES,
    SearchCourse,
    track_of_course,
)
from warehouse_core.render.palette import COLORS, INK, PAPER, SHELF, WARNING, Color
from warehouse_core.viz.axes import box_in, draw_grid
from warehouse_core.viz.figure import DPI, SceneFigure, make_figure, make_window
from warehouse_core.viz.replay import Replay
from warehouse_core.wording import printable
from warehouse_core.world.tiles import EMPTY, WALL

MAX_FRAMES = 120
"""Most frames of an animation, the first and the last included."""

FRAME_MS = 100.0

WIDTH, HEIGHT, MARGIN = 1366, 860, 24
"""Largest picture and the room around a panel, in pixels."""

HEAD, FOOT, WORDS, TICKS = 64, 52, 76, 20
"""Room for the title, the legend, the words above a panel and the numbers of rows, in pixels."""

MIN_WIDTH, MIN_PANEL, MAX_CELL = 940, 340, 40
"""Least width of a picture, for its legend, and of a panel, for its words; largest cell."""

LINED_CELL = 12
"""Least side of a cell, in pixels, for lines between the cells."""

PATH: Color = WARNING

FLOOR, SHELVES, MARKED = range(3)
"""Indices into ``CELL_COLORS``; marks follow from ``MARKED`` on."""

CELL_COLORS = np.round(255 * np.array([COLORS[EMPTY], SHELF, *MARK_COLORS.values()])).astype(
    np.uint8
)


class SearchPanel:
    """Draws a search at a place of a figure, whose cells have ``cell`` pixels, row 0 on top."""

    def __init__(
        self, figure: SceneFigure, left: float, top: float, cell: float, course: SearchCourse
    ) -> None:
        self._course, layout = course, course.layout
        height, width = layout.height, layout.width
        is_wall = np.array([list(row) for row in layout.rows]) == WALL
        self._ground = np.where(is_wall, SHELVES, FLOOR)
        size = figure.get_size_inches() * DPI
        axes = figure.add_axes(box_in(tuple(size), left, top, cell * width, cell * height))
        every = next((n for n in (1, 5, 10, 50, 100, 500) if n * cell >= TICKS), 1000)
        lines = 0.6 if cell >= LINED_CELL else 0.0
        draw_grid(axes, (height, width), every, line_width=lines, zorder=2, label_size=9)
        axes.xaxis.tick_top()
        place: dict[str, Any] = {"extent": (0, width, height, 0), "aspect": "auto"}
        self._image = axes.imshow(CELL_COLORS[self._ground], zorder=1, **place)
        points = cell * 72 / DPI
        states, line = course.solution.states, max(1.4, points / 5)
        self._path = axes.plot(
            [col + 0.5 for _, col in states], [row + 0.5 for row, _ in states], color=PATH,
            linewidth=line, zorder=4, solid_capstyle="round",
            path_effects=[withStroke(linewidth=line + 1.6, foreground=PAPER)],
        )[0]  # fmt: skip
        mark: dict[str, Any] = {"markeredgecolor": INK, "linestyle": "none"}
        end_size = max(13.0, 0.85 * points)
        for name, (row, col) in zip("SG", course.ends, strict=True):
            at = col + 0.5, row + 0.5
            axes.plot(*at, "o", color=PAPER, markersize=end_size, zorder=6, clip_on=False, **mark)
            axes.text(
                *at, name, fontsize=0.68 * end_size, fontweight="bold", color=INK, ha="center",
                va="center_baseline", zorder=7,
            )  # fmt: skip
        words: dict[str, Any] = {"parse_math": False, "color": INK}
        x, y = left / size[0], 1 - top / size[1]
        figure.text(x, y + 46 / size[1], course.name, fontsize=13, fontweight="bold", **words)
        self._counts = figure.text(x, y + 24 / size[1], "", fontsize=11, **words)
        artists: list[Any] = [*axes.images, *axes.collections, *axes.lines, *axes.texts]
        artists.sort(key=lambda artist: artist.get_zorder())
        for artist in (*artists, self._counts):
            figure.add_mover(artist)

    def show(self, count: int) -> None:
        """Show the search after ``count`` expansions, or at its end if it has fewer."""
        course = self._course
        marks = course.marks_after(count)
        self._image.set_data(CELL_COLORS[np.where(marks < 0, self._ground, MARKED + marks)])
        is_over = course.is_over(count)
        self._path.set_visible(is_over and course.solution.found)
        self._counts.set_text("   ".join(course.words_after(count)))
        self._counts.set_fontweight("bold" if is_over else "normal")


class _SearchScene:
    """Searches side by side in one figure, expansion by expansion."""

    def __init__(self, courses: Sequence[SearchCourse], title: str, window: bool) -> None:
        self._longest, layout = max(map(len, courses)), courses[0].layout
        self._each = max(1, math.ceil(self._longest / (MAX_FRAMES - 1)))
        cell, columns = arranged(layout.height, layout.width, len(courses))
        right = TICKS + max(cell * layout.width, MIN_PANEL) + MARGIN
        down = WORDS + cell * layout.height + MARGIN
        width = max(MIN_WIDTH, MARGIN + columns * right)
        height = HEAD + math.ceil(len(courses) / columns) * down + FOOT
        self.root = (make_window if window else make_figure)((width / DPI, height / DPI))
        self._panels = []
        for place, course in enumerate(courses):
            row, column = divmod(place, columns)
            left, top = MARGIN + TICKS + column * right, HEAD + WORDS + row * down
            self._panels.append(SearchPanel(self.root, left, top, cell, course))
        words: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        x = MARGIN / width
        self.root.text(x, 1 - 24 / height, printable(title), fontsize=14, weight="bold", **words)
        self._counter = self.root.text(x, 1 - 54 / height, "", fontsize=12, **words)
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


def arranged(height: int, width: int, panels: int) -> tuple[float, int]:
    """Return the side of a cell, in pixels, and the columns of panels that make it largest."""

    def cell_in(columns: int) -> float:
        wide = (WIDTH - MARGIN) / columns - MARGIN - TICKS
        high = (HEIGHT - HEAD - FOOT) / math.ceil(panels / columns) - WORDS - MARGIN
        if columns > 1 and wide < MIN_PANEL:
            return 0.0  # the words above a panel would overlap the words above the next one
        cell = min(wide / width, high / height, MAX_CELL)
        return math.floor(cell) if cell >= 1 else cell  # whole pixels have sharp edges

    columns = max(range(panels, 0, -1), key=cell_in)
    return cell_in(columns), columns


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
        "expanded now": Line2D([], [], color=WARNING, **square),
        "path": Line2D([], [], color=PATH, linewidth=3.5),
    }
    figure.legend(
        [*signs.values()], [*signs], loc="lower left", ncols=len(signs), fontsize=11,
        frameon=False, handlelength=1.4, columnspacing=1.1, handletextpad=0.4,
        bbox_to_anchor=(0.01, 0.0),
    )  # fmt: skip
