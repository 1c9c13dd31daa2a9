"""A whole picture: the warehouse, the charts beside it, the battery and one legend.

It is the one place that lays a picture out, for windows, files and notebooks alike.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import (
    COLORS,
    HIT,
    INK,
    TRAIL_COLORS,
    TRAIL_STYLES,
    UNKNOWN,
    UNKNOWN_STRIPE,
)
from warehouse_core.viz.charts import BatteryBar, DistanceChart, MotionChart, RewardChart
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.grid_view import ROUTE_STYLE, GridView
from warehouse_core.viz.track import Track
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED

Chart = RewardChart | DistanceChart | MotionChart | BatteryBar
DISTANCES = tuple(DistanceChart.NAMES.values())

MakeFigure = Callable[[tuple[float, float]], SceneFigure | SubFigure]
"""Makes a figure of a width and height in inches, or a part of a ``SceneFigure``."""

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


def _plan(track: Track, foot: float, body: float = 0.0) -> _Plan:
    height, width = len(track.tiles[0]), len(track.tiles[0][0])
    cell = min(GRID_INCHES[0] / width, GRID_INCHES[1] / height, MAX_CELL_INCHES)
    has_charts = bool(track.metrics.keys() - {"battery"}) or bool(track.clock)
    return _Plan(
        cell=cell,
        grid_width=cell * width,
        grid_height=cell * height,
        left_width=max(cell * width, 4.8),
        body_height=max(cell * height, 4.2 if track.clock else 3.2 if has_charts else body),
        has_charts=has_charts,
        has_battery="battery" in track.metrics,
        foot=foot,
    )


class Scene:
    """A track drawn into a figure, one frame at a time.

    Args:
        track: with at least one frame.
        make_figure: makes the figure, once its size is known.
        length: steps, and one, to leave room for where the track is still growing.
        height: of the figure in inches, where it is to be higher than the track needs.
        body: height of the grid's part in inches, for a track without charts beside one with.
        legend: draw the legend along the bottom.
    """

    def __init__(
        self,
        track: Track,
        make_figure: MakeFigure,
        *,
        length: int | None = None,
        height: float = 0.0,
        body: float = 0.0,
        legend: bool = True,
    ) -> None:
        self._track = track
        self._length = length or track.steps + 1
        plan = _plan(track, FOOT if legend else MARGIN, body)
        self.figure = make_figure(plan.size)
        root = self.figure.get_figure(root=True)
        assert isinstance(root, SceneFigure), "make_figure makes nothing else"
        self.root = root
        self._width, self._height = plan.size[0], max(height, plan.size[1])
        self._grid = self._make_grid(plan)
        self._charts = [*self._make_charts(plan), *self._make_battery(plan)]
        self._make_texts()
        if legend:
            draw_legend(self.figure, has_belief=bool(track.routes))
        self.show(0)

    def __len__(self) -> int:
        return len(self._track)

    def show(self, frame: int, track: Track | None = None) -> None:
        """Change everything that moves to what it is in ``frame``, of a grown track if given."""
        track = self._track = track or self._track
        self._grid.show_tiles(track.tiles[frame])
        for robot, poses in zip(self._grid.robots, [track.poses, *track.others], strict=True):
            robot.show(poses[: frame + 1])
        if track.routes:
            self._grid.show_route(track.routes[frame])
        self._grid.show_hits(track.hits[frame])
        for chart in self._charts:
            chart.show(track, frame)
        self._title.set_text(track.title)
        clock = f"   {track.clock[frame]:.1f} s" if track.clock else ""
        step = math.ceil(track.progress[frame])
        self._counter.set_text(f"step {step} of {self._length - 1}{clock}")
        self._caption.set_text(track.captions[frame])
        self._ending.set_text(track.ending.upper() if frame == len(track) - 1 else "")

    def _make_grid(self, plan: _Plan) -> GridView:
        left = MARGIN + (plan.left_width - plan.grid_width) / 2
        top = HEAD + (plan.body_height - plan.grid_height) / 2
        axes = self._axes(left, top, plan.grid_width, plan.grid_height)
        return GridView(
            self.root, axes, plan.cell * 72, self._track.tiles[0], 1 + len(self._track.others)
        )

    def _make_charts(self, plan: _Plan) -> list[Chart]:
        kinds: list[type[RewardChart | DistanceChart | MotionChart]] = [
            kind
            for kind, names in ((RewardChart, ("rewards",)), (DistanceChart, DISTANCES))
            if any(name in self._track.metrics for name in names)
        ]
        kinds += [MotionChart] if self._track.clock else []
        gap = 0.55
        height = (plan.body_height - gap * (len(kinds) - 1)) / max(len(kinds), 1)
        charts: list[Chart] = []
        for kind in kinds:
            top = HEAD + len(charts) * (height + gap)
            axes = self._axes(MARGIN + plan.left_width + 0.75, top, CHART_INCHES, height)
            charts.append(kind(self.root, axes, self._track, self._length))
            if kind is kinds[-1]:
                axes.set_xlabel("step", fontsize=8, labelpad=1)
        return charts

    def _make_battery(self, plan: _Plan) -> list[Chart]:
        if not plan.has_battery:
            return []
        left = MARGIN + (plan.left_width - plan.grid_width) / 2
        axes = self._axes(left, HEAD + plan.body_height + 0.12, plan.grid_width, BAR)
        return [BatteryBar(self.root, axes)]

    def _make_texts(self) -> None:
        left, right = MARGIN / self._width, 1 - MARGIN / self._width
        title, line = 1 - 0.2 / self._height, 1 - 0.46 / self._height
        common: dict[str, Any] = {"parse_math": False, "va": "center", "color": INK}
        self._title = self.figure.text(left, title, "", fontsize=10, fontweight="bold", **common)
        self._counter = self.figure.text(left, line, "", fontsize=9, **common)
        self._caption = self.figure.text(
            (MARGIN + (2.1 if self._track.clock else 1.4)) / self._width,
            line,
            "",
            fontsize=9,
            fontweight="bold",
            **common,
        )
        self._ending = self.figure.text(
            right, title, "", fontsize=10, fontweight="bold", ha="right", **common
        )
        for text in (self._title, self._counter, self._caption, self._ending):
            self.root.add_mover(text)

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


def _part(part: SubFigure, size: tuple[float, float]) -> SubFigure:
    """Return ``part``, which has been made already, as a ``MakeFigure``."""
    return part


class PairScene:
    """Two tracks side by side in one figure, under one legend.

    Two continuous ones go by the clock, others step by step.

    Args:
        left: a track with at least one frame.
        right: another; the shorter one waits at its end.
        make_figure: makes the figure, once its size is known.
    """

    def __init__(
        self, left: Track, right: Track, make_figure: Callable[[tuple[float, float]], SceneFigure]
    ) -> None:
        body = max(_plan(track, MARGIN).body_height for track in (left, right))
        sizes = [_plan(track, MARGIN, body).size for track in (left, right)]
        width, height = sizes[0][0] + sizes[1][0], max(size[1] for size in sizes)
        self.root = make_figure((width, height + FOOT))
        halves: Any = self.root.subfigures(2, 1, height_ratios=[height, FOOT])
        top, bottom = halves
        parts = top.subfigures(1, 2, width_ratios=[size[0] for size in sizes])
        length = max(left.steps, right.steps) + 1
        tracks, by_clock = (left, right), bool(left.clock and right.clock)
        self._times = [track.clock if by_clock else track.progress for track in tracks]
        self._scenes = [
            Scene(
                track, partial(_part, part), length=length, height=height, body=body, legend=False
            )
            for track, part in zip(tracks, parts, strict=True)
        ]
        self._moments = sorted({*self._times[0], *self._times[1]})
        draw_legend(bottom, has_belief=bool(left.routes or right.routes))

    def __len__(self) -> int:
        return len(self._moments)

    def show(self, frame: int) -> None:
        """Show both tracks as far as they have got at the same moment."""
        for times, scene in zip(self._times, self._scenes, strict=True):
            scene.show(bisect_right(times, self._moments[frame]) - 1)


def draw_legend(figure: SceneFigure | SubFigure, *, has_belief: bool = False) -> Legend:
    """Draw the one legend along the bottom: tiles, robots and trails, with their letters.

    Args:
        figure: to draw into.
        has_belief: explain what is not seen yet, and the plan.
    """
    handles: list[Artist] = []
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
    if has_belief:
        handles += _belief_handles()
        labels += ["not seen yet", "plan"]
    return figure.legend(
        handles, labels, loc="lower center", ncols=6 if has_belief else 5, fontsize=8,
        frameon=False, handlelength=2.0, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip


def _belief_handles() -> list[Artist]:
    """Return the signs of what is not seen yet, and of the plan."""
    unseen = Rectangle((0, 0), 1, 1, facecolor=UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="//////")
    return [unseen, Line2D([], [], color=INK, linestyle=ROUTE_STYLE, lw=2.2)]
