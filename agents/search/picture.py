"""An animated search, or several side by side from the same start to the same goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.lines import Line2D

from agents.search.course_track import track_of_course
from agents.search.panel import PATH, SearchPanel
from agents.search.trace import FRONTIER, MAX_PANELS, SHADES, SearchCourse
from warehouse_core.render.palette import COLORS, INK, PAPER, WARNING
from warehouse_core.viz.axes import box_in
from warehouse_core.viz.figure import DPI, SceneFigure, make_figure, make_window
from warehouse_core.viz.replay import Replay
from warehouse_core.wording import printable
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL

MAX_FRAMES = 120
"""Most frames of an animation, the first and the last included."""

FRAME_MS = 100.0

# In pixels, because cells of a whole number of pixels have sharp edges.
MAX_SIZE = (1366, 860)
MARGIN, HEAD, FOOT = 24, 76, 52
PANEL_LEFT, PANEL_HEAD, PANEL_FOOT = 20, 68, 12
MIN_WIDTH = 940  # for the title and the legend
MIN_PANEL, MAX_CELL, GOOD_CELL = 340, 40, 28


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
        "wall": Line2D([], [], color=COLORS[WALL], **square),
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
