"""An animated search, or several side by side on the same floor, from the same start to a goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.lines import Line2D

from agents.search.panel import FRONTIER, PATH, SHADES, SearchPanel
from agents.search.trace import SearchCourse
from warehouse_core.render.palette import COLORS, INK, WARNING
from warehouse_core.viz.figure import DPI, SceneFigure, make_figure, make_window
from warehouse_core.viz.replay import Replay
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL, Cell

MOST_FRAMES = 120
"""Of an animation, the first and the last included."""

MOST_PANELS = 6

FRAME_MS = 100

# In pixels, so that a cell is a whole number of them and its edges are sharp.
LARGEST = (1400, 860)
MARGIN, HEAD, FOOT = 24, 56, 40
PANEL_LEFT, PANEL_HEAD, PANEL_FOOT = 20, 54, 12
LEAST_WIDTH = 600  # for the title and the legend
LEAST_PANEL, LARGEST_CELL, GOOD_CELL = 240, 40, 16


@dataclass(frozen=True, slots=True)
class _Plan:
    """How panels are laid out, in pixels."""

    columns: int
    rows: int
    cell: float
    panel: tuple[float, float]

    @property
    def size(self) -> tuple[float, float]:
        return (
            max(LEAST_WIDTH, MARGIN + self.columns * (PANEL_LEFT + self.panel[0] + MARGIN)),
            HEAD + self.rows * (PANEL_HEAD + self.panel[1] + PANEL_FOOT) + FOOT,
        )


class SearchScene:
    """Searches side by side in one figure, expansion by expansion.

    Args:
        layout: that is searched.
        start: where all begin.
        goal: where they want to go.
        courses: of the searches, at least one and at most ``MOST_PANELS``.
        title: shown above them.
        window: draw into a window.

    Raises:
        ValueError: none, or too many.
    """

    def __init__(
        self,
        layout: Layout,
        start: Cell,
        goal: Cell,
        courses: Sequence[SearchCourse],
        title: str,
        *,
        window: bool = False,
    ) -> None:
        if not 1 <= len(courses) <= MOST_PANELS:
            raise ValueError(f"{len(courses)} searches; there must be 1..{MOST_PANELS}")
        self._longest = max(len(course) for course in courses)
        self._each = max(1, math.ceil(self._longest / (MOST_FRAMES - 1)))
        self._plan = _plan(layout, len(courses))
        width, height = self._plan.size
        self.root = (make_window if window else make_figure)((width / DPI, height / DPI))
        add = partial(self._add_panel, layout, (start, goal))
        self._panels = [add(place, course) for place, course in enumerate(courses)]
        self._draw_title(title)
        draw_legend(self.root)
        self.show(0)

    def __len__(self) -> int:
        return math.ceil(self._longest / self._each) + 1

    def show(self, frame: int) -> None:
        """Show all searches after the same number of expansions."""
        count = min(frame * self._each, self._longest)
        for panel in self._panels:
            panel.show(count)
        self._counter.set_text(f"after {count} of {self._longest} expansions")

    def _add_panel(
        self, layout: Layout, ends: tuple[Cell, Cell], place: int, course: SearchCourse
    ) -> SearchPanel:
        plan = self._plan
        row, column = divmod(place, plan.columns)
        (width, height), (panel_width, panel_height) = plan.size, plan.panel
        left = MARGIN + PANEL_LEFT + column * (PANEL_LEFT + panel_width + MARGIN)
        top = HEAD + PANEL_HEAD + row * (PANEL_HEAD + panel_height + PANEL_FOOT)
        drawn_width, drawn_height = layout.width * plan.cell, layout.height * plan.cell
        axes = self.root.add_axes(
            (
                left / width,
                1 - (top + drawn_height) / height,
                drawn_width / width,
                drawn_height / height,
            )
        )
        return SearchPanel(self.root, axes, plan.cell * 72 / DPI, layout, ends, course)

    def _draw_title(self, title: str) -> None:
        width, height = self._plan.size
        common: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        left = MARGIN / width
        self.root.text(left, 1 - 20 / height, title, fontsize=11, fontweight="bold", **common)
        self._counter = self.root.text(left, 1 - 42 / height, "", fontsize=9, **common)
        self.root.add_mover(self._counter)


class SearchReplay(Replay):
    """The animation of a scene of searches, with the keys and the formats of a replay.

    Args:
        scene: to be played.
        title: of the page that it can be saved as.
        window: whether the scene is drawn into a window, which ``show`` opens.
    """

    def __init__(self, scene: SearchScene, title: str, *, window: bool) -> None:
        # A replay's own beginning makes the scene of an episode.
        self._play(scene, title, float(FRAME_MS), window)


def search_replay(
    layout: Layout,
    start: Cell,
    goal: Cell,
    courses: Sequence[SearchCourse],
    title: str,
    *,
    window: bool = False,
) -> SearchReplay:
    """Return the animation of searches side by side.

    Raises:
        ValueError: no search, or more than ``MOST_PANELS``.
    """
    scene = SearchScene(layout, start, goal, courses, title, window=window)
    return SearchReplay(scene, title, window=window)


def draw_legend(figure: SceneFigure) -> None:
    """Draw the one legend along the bottom."""
    square: dict[str, Any] = {"marker": "s", "markersize": 9, "linestyle": "none", "mec": INK}
    signs = {
        "wall": Line2D([], [], color=COLORS[WALL], **square),
        "expanded first": Line2D([], [], color=SHADES[0], **square),
        "expanded last": Line2D([], [], color=SHADES[-1], **square),
        "frontier": Line2D([], [], color=FRONTIER, **square),
        "expanded now": Line2D([], [], color=WARNING, **(square | {"marker": "D"})),
        "path": Line2D([], [], color=PATH, linewidth=2.2),
    }
    figure.legend(
        [*signs.values()], [*signs], loc="lower left", ncols=len(signs), fontsize=8,
        frameon=False, handlelength=1.6, columnspacing=1.2, handletextpad=0.4,
        bbox_to_anchor=(0.01, 0.0),
    )  # fmt: skip


def _plan(layout: Layout, panels: int) -> _Plan:
    """Lay panels out in one row if cells are large enough there, or so that they are largest."""
    plans = [_plan_of(layout, panels, columns) for columns in range(panels, 0, -1)]
    if plans[0].cell >= GOOD_CELL:
        return plans[0]
    # Of those with the largest cells the one that leaves the fewest places empty.
    return max(plans, key=lambda plan: (plan.cell, -plan.columns * plan.rows))


def _plan_of(layout: Layout, panels: int, columns: int) -> _Plan:
    rows = math.ceil(panels / columns)
    wide = (LARGEST[0] - MARGIN) / columns - MARGIN - PANEL_LEFT
    high = (LARGEST[1] - HEAD - FOOT) / rows - PANEL_HEAD - PANEL_FOOT
    cell = min(wide / layout.width, high / layout.height, LARGEST_CELL)
    cell = math.floor(cell) if cell >= 1 else cell
    if columns > 1 and wide < LEAST_PANEL:
        cell = 0.0  # the words above a panel would run into those of the next
    return _Plan(columns, rows, cell, (max(cell * layout.width, LEAST_PANEL), cell * layout.height))
