"""A whole picture: the warehouse, the charts beside it, the battery and one legend.

It is the one place that lays a picture out, for windows, files and notebooks alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.legend import Legend
from matplotlib.lines import Line2D

from warehouse_core.charts import BatteryBar, DistanceChart, RewardChart
from warehouse_core.grid_view import GridView
from warehouse_core.palette import COLORS, HIT, INK, TRAIL_COLORS, TRAIL_STYLES
from warehouse_core.scene_figure import SceneFigure
from warehouse_core.sight import ROBOT_EMPTY, ROBOT_LOADED
from warehouse_core.track import Track
from warehouse_core.warehouse_env import LEGEND

Chart = RewardChart | DistanceChart | BatteryBar
DISTANCES = tuple(DistanceChart.NAMES.values())

MakeFigure = Callable[[tuple[float, float]], SceneFigure]
"""Makes a figure of a width and height in inches."""

GRID_INCHES = (6.4, 4.6)
"""Largest width and height of the grid."""
MAX_CELL_INCHES = 0.55
CHART_INCHES = 3.3
MARGIN = 0.3
HEAD, FOOT, BAR = 0.85, 0.75, 0.26


@dataclass(frozen=True, slots=True)
class _Plan:
    """Where things go, in inches."""

    cell: float
    grid_width: float
    grid_height: float
    left_width: float
    body_height: float
    has_charts: bool
    has_battery: bool
    foot: float

    @property
    def size(self) -> tuple[float, float]:
        charts = 0.75 + CHART_INCHES if self.has_charts else 0.0
        battery = BAR + 0.15 if self.has_battery else 0.0
        return (
            MARGIN + self.left_width + charts + MARGIN,
            HEAD + self.body_height + battery + self.foot,
        )


def _plan(track: Track, foot: float) -> _Plan:
    height, width = len(track.tiles[0]), len(track.tiles[0][0])
    cell = min(GRID_INCHES[0] / width, GRID_INCHES[1] / height, MAX_CELL_INCHES)
    has_charts = bool(track.metrics.keys() - {"battery"})
    return _Plan(
        cell=cell,
        grid_width=cell * width,
        grid_height=cell * height,
        left_width=max(cell * width, 4.8),
        body_height=max(cell * height, 3.2 if has_charts else 0.0),
        has_charts=has_charts,
        has_battery="battery" in track.metrics,
        foot=foot,
    )


class Scene:
    """A track drawn into a figure, one frame at a time.

    Args:
        track: with at least one frame.
        make_figure: makes the figure, once its size is known.
        length: frames to leave room for, where the track is still growing.
        legend: draw the legend along the bottom.

    """

    def __init__(
        self,
        track: Track,
        make_figure: MakeFigure,
        *,
        length: int | None = None,
        legend: bool = True,
    ) -> None:
        self._track = track
        self._length = length or len(track)
        plan = _plan(track, FOOT if legend else MARGIN)
        self.figure = make_figure(plan.size)
        self._width, self._height = plan.size
        self._grid = self._make_grid(plan)
        self._charts = [*self._make_charts(plan), *self._make_battery(plan)]
        self._make_texts()
        if legend:
            draw_legend(self.figure)
        self.show(0)

    def show(self, frame: int, track: Track | None = None) -> None:
        """Change everything that moves to what it is in ``frame``, of a grown track if given."""
        track = self._track = track or self._track
        self._grid.show_tiles(track.tiles[frame])
        self._grid.show_trail(track.poses[: frame + 1])
        self._grid.show_robot(track.poses[frame])
        self._grid.show_hits(track.hits[frame])
        for chart in self._charts:
            chart.show(track, frame)
        self._title.set_text(track.title)
        self._counter.set_text(f"step {frame} of {self._length - 1}")
        self._caption.set_text(track.captions[frame])
        self._ending.set_text(track.ending.upper() if frame == len(track) - 1 else "")

    def _make_grid(self, plan: _Plan) -> GridView:
        left = MARGIN + (plan.left_width - plan.grid_width) / 2
        top = HEAD + (plan.body_height - plan.grid_height) / 2
        axes = self._axes(left, top, plan.grid_width, plan.grid_height)
        return GridView(self.figure, axes, plan.cell * 72, self._track.tiles[0])

    def _make_charts(self, plan: _Plan) -> list[Chart]:
        kinds = [
            kind
            for kind, names in ((RewardChart, ("rewards",)), (DistanceChart, DISTANCES))
            if any(name in self._track.metrics for name in names)
        ]
        gap = 0.55
        height = (plan.body_height - gap * (len(kinds) - 1)) / max(len(kinds), 1)
        charts: list[Chart] = []
        for kind in kinds:
            top = HEAD + len(charts) * (height + gap)
            axes = self._axes(MARGIN + plan.left_width + 0.75, top, CHART_INCHES, height)
            charts.append(kind(self.figure, axes, self._track, self._length))
            if kind is kinds[-1]:
                axes.set_xlabel("step", fontsize=8, labelpad=1)
        return charts

    def _make_battery(self, plan: _Plan) -> list[Chart]:
        if not plan.has_battery:
            return []
        left = MARGIN + (plan.left_width - plan.grid_width) / 2
        axes = self._axes(left, HEAD + plan.body_height + 0.12, plan.grid_width, BAR)
        return [BatteryBar(self.figure, axes)]

    def _make_texts(self) -> None:
        left, right = MARGIN / self._width, 1 - MARGIN / self._width
        title, line = 1 - 0.2 / self._height, 1 - 0.46 / self._height
        common: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        self._title = self.figure.text(left, title, "", fontsize=10, fontweight="bold", **common)
        self._counter = self.figure.text(left, line, "", fontsize=9, **common)
        self._caption = self.figure.text(
            (MARGIN + 1.4) / self._width, line, "", fontsize=9, fontweight="bold", **common
        )
        self._ending = self.figure.text(
            right, title, "", fontsize=10, fontweight="bold", ha="right", **common
        )
        for text in (self._title, self._counter, self._caption, self._ending):
            self.figure.add_mover(text)

    def _axes(self, left: float, top: float, width: float, height: float) -> Axes:
        """Add axes at a place in inches from the top left corner."""
        return self.figure.add_axes(
            (
                left / self._width,
                1 - (top + height) / self._height,
                width / self._width,
                height / self._height,
            )
        )


def draw_legend(figure: SceneFigure) -> Legend:
    """Draw the one legend along the bottom: tiles, robots and trails, with their letters."""
    handles: list[Line2D] = []
    labels = []
    for character, meaning in LEGEND.items():
        is_robot = character in (ROBOT_EMPTY, ROBOT_LOADED)
        handles.append(
            Line2D([], [], marker="o" if is_robot else "s", markersize=10, linestyle="none",
                   markerfacecolor=COLORS[character], markeredgecolor=INK, markeredgewidth=0.6)
        )  # fmt: skip
        labels.append(f"{character}  {meaning}")
    for loaded, color in TRAIL_COLORS.items():
        handles.append(Line2D([], [], color=color, linestyle=TRAIL_STYLES[loaded], lw=2.2))
        labels.append(f"trail {'loaded' if loaded else 'empty'}")
    handles.append(
        Line2D([], [], marker="*", markersize=11, linestyle="none", color=HIT, mec=INK, mew=0.6)
    )
    labels.append("hit")
    return figure.legend(
        handles, labels, loc="lower center", ncols=5, fontsize=8, frameon=False,
        handlelength=2.0, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip
