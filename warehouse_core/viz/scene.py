"""A whole picture: the warehouse, the charts beside it, the battery and the legend.

The layout of pictures is here, for windows, files and notebooks alike.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes

from warehouse_core.render.palette import INK
from warehouse_core.viz.axes import box_in
from warehouse_core.viz.charts import BatteryBar, DistanceChart, MotionChart, RewardChart, TimeAxis
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.fleet_charts import (
    FLEET_CHARTS,
    DeliveryChart,
    EnergyChart,
    LatenessChart,
)
from warehouse_core.viz.grid_view import GridView, shown_size
from warehouse_core.viz.legend import draw_legend
from warehouse_core.viz.tracks.track import Track

StepChart = RewardChart | DistanceChart | MotionChart | DeliveryChart | LatenessChart | EnergyChart
Chart = StepChart | BatteryBar

MakeFigure = Callable[[tuple[float, float]], SceneFigure]
"""Makes a figure of a width and height in inches."""

GRID_INCHES, FLEET_INCHES = (6.4, 4.6), (10.0, 6.4)
"""Maximum width and height of the grid; that of a fleet has room for numbers on robots."""
MAX_CELL_INCHES = 1.05
CHART_INCHES = 3.3
MARGIN = 0.3
HEAD, BAR, LEGEND = 1.0, 0.2, 1.75

MAX_CAPTION, MIN_CAPTION = 18.0, 10.0
"""Sizes of the action and its reason in points; of those too long for a line, two are smaller."""
LETTER_WIDTH = 0.66
"""Mean width of a letter, as a share of its size."""

LONG_SECONDS = 100
"""Longer episodes show whole seconds."""

MOTION_PARTS = 100
"""The chart of a motion grows in so many parts, or with each step if there are more steps."""


class Plan:
    """Sizes of the parts of a picture, in inches.

    Args:
        track: to be drawn.
        foot: height below the grid.
        beside: width of the legend.
    """

    def __init__(self, track: Track, foot: float, beside: float) -> None:
        width, height = shown_size(track)
        widest, highest = FLEET_INCHES if track.frames[0].fleet else GRID_INCHES
        self.cell = min(widest / width, highest / height, MAX_CELL_INCHES)
        self.grid_width, self.grid_height = self.cell * width, self.cell * height
        metrics = track.metrics.keys() - {"battery"}
        has_charts = bool(metrics or track.is_continuous or track.shift)
        self.has_battery = "battery" in track.metrics
        least = 4.2 if track.is_continuous or track.shift else 3.2 if has_charts else 0.0
        self.left_width = max(self.grid_width, 4.8)
        self.body_height = max(self.grid_height, least)
        charts = 0.75 + CHART_INCHES if has_charts else 0.0
        battery = BAR + 0.12 if self.has_battery else 0.0
        self.size = (
            MARGIN + self.left_width + charts + MARGIN + beside,
            HEAD + self.body_height + battery + foot,
        )


class Scene:
    """A track drawn into a figure, one frame at a time.

    Args:
        track: with at least one frame.
        make_figure: makes the figure of a width and height in inches.
        length: number of steps plus one to leave room for, where the track is still growing.
        legend: draw the legend along the right side.
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
        self._length = length or track.steps + 1
        self._time = TimeAxis(length - 1) if length else TimeAxis.of(track)
        # Without a battery there are only the words below charts.
        foot = MARGIN if "battery" in track.metrics or not legend else 0.5
        plan = Plan(track, foot, LEGEND if legend else 0.0)
        self.root = make_figure(plan.size)
        self._width, self._height = plan.size
        grid_left = MARGIN + (plan.left_width - plan.grid_width) / 2
        grid_top = HEAD + (plan.body_height - plan.grid_height) / 2
        axes = self._axes(grid_left, grid_top, plan.grid_width, plan.grid_height)
        self._grid = GridView(self.root, axes, plan.cell * 72, track)
        self._charts = self._make_charts(plan)
        if plan.has_battery:
            top = HEAD + plan.body_height + 0.12
            axes = self._axes(MARGIN, top, plan.left_width, BAR)
            self._charts.append(BatteryBar(self.root, axes))
        self._charted: tuple[int, int, int] | None = None
        self._make_texts()
        if legend:
            draw_legend(self.root, [track])
        self.show(0)

    def __len__(self) -> int:
        return len(self._track)

    def show(self, frame: int, track: Track | None = None) -> None:
        """Move everything that moves to its place in a frame.

        Args:
            frame: its number.
            track: shown from now on, if given: the same one, grown by more frames.
        """
        track = self._track = track or self._track
        now = track.frames[frame]
        self._grid.show_tiles(now.tiles)
        self._grid.show_robots(track.frames, frame)
        self._grid.show_route(now.route)
        self._grid.show_hits(now.hits)
        charted = self._charted_frame(track, frame)
        for chart in self._charts:
            if self._has_grown(chart, charted, track):
                chart.show(track, charted)
        self._charted = charted, track.step_at(frame), len(track)
        self._title.set_text(track.title)
        digits = 0 if track.frames[-1].clock > LONG_SECONDS else 1
        clock = f"   {now.clock:.{digits}f} s" if track.is_continuous else ""
        self._counter.set_text(f"step {math.ceil(now.progress)} of {self._length - 1}{clock}")
        words, size = self._fitted(now.caption)
        if words != self._caption.get_text():
            self._caption.set(text=words, fontsize=size)
        self._ending.set_text(track.ending.upper() if frame == len(track) - 1 else "")

    def _has_grown(self, chart: Chart, frame: int, track: Track) -> bool:
        """Return whether a chart differs from the one that is drawn."""
        now = frame, track.step_at(frame), len(track)
        if self._charted is None or isinstance(chart, MotionChart):
            return now != self._charted
        return now[1:] != self._charted[1:]

    def _charted_frame(self, track: Track, frame: int) -> int:
        """Return the first frame whose charts can be told from those of the frame before it."""

        def place(number: int) -> tuple[int, int]:
            progress = track.frames[number].progress
            return math.floor(progress), math.floor(progress * MOTION_PARTS / self._length)

        while frame and place(frame - 1) == place(frame):
            frame -= 1
        return frame

    def _fitted(self, caption: str) -> tuple[str, float]:
        """Return a caption in one or two lines, and the size at which it fits."""
        points = 72 * (self._width - 2 * MARGIN) / LETTER_WIDTH
        size = points / max(len(caption), 1)
        if size < MIN_CAPTION:
            lines = textwrap.wrap(caption, max(len(caption) * 6 // 11, 1), max_lines=2)
            caption = "\n".join(lines)
            size = points / max(map(len, lines), default=1)
        most = MAX_CAPTION * (0.7 if "\n" in caption else 1)
        return caption, min(size, most)

    def _make_charts(self, plan: Plan) -> list[Chart]:
        metrics = self._track.metrics.keys()
        is_shift = self._track.shift is not None
        is_shown: dict[type[StepChart], bool] = {
            RewardChart: "rewards" in metrics,
            DistanceChart: not metrics.isdisjoint(DistanceChart.NAMES.values()),
            MotionChart: self._track.is_continuous and not is_shift,
            **dict.fromkeys(FLEET_CHARTS, is_shift),
        }
        kinds = [kind for kind, shown in is_shown.items() if shown]
        gap = 0.55
        height = (plan.body_height - gap * (len(kinds) - 1)) / max(len(kinds), 1)
        charts: list[Chart] = []
        for kind in kinds:
            top = HEAD + len(charts) * (height + gap)
            axes = self._axes(MARGIN + plan.left_width + 0.75, top, CHART_INCHES, height)
            charts.append(kind(self.root, axes, self._track, self._time))
            if kind is kinds[-1]:
                axes.set_xlabel(self._time.label, fontsize=8, labelpad=1)
        return charts

    def _make_texts(self) -> None:
        left, right = MARGIN / self._width, 1 - MARGIN / self._width
        title, line = 1 - 0.2 / self._height, 1 - 0.56 / self._height
        common: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        self._title = self.root.text(left, title, "", fontsize=9, **common)
        self._counter = self.root.text(right, title, "", fontsize=9, ha="right", **common)
        self._caption = self.root.text(left, line, "", fontweight="bold", **common)
        self._ending = self.root.text(
            0.5, title, "", fontsize=11, fontweight="bold", ha="center", **common
        )
        for text in (self._title, self._counter, self._caption, self._ending):
            self.root.add_mover(text)

    def _axes(self, left: float, top: float, width: float, height: float) -> Axes:
        """Add axes at a place in inches from the top left corner."""
        size = self._width, self._height
        return self.root.add_axes(box_in(size, left, top, width, height))
