"""The charts beside the warehouse: rewards, distances, motion, orders and batteries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import EngFormatter, MaxNLocator

from warehouse_core.render.palette import (
    BATTERY,
    COLORS,
    FAINT,
    INK,
    PALE_WARNING,
    PAPER,
    WARNING,
)
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.axes.look import SMALLEST
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.track import Frame, Track
from warehouse_core.world.tiles import DROPOFF, PICKUP, TILES

WARNING_SHARE = 0.2
"""Share of a full battery below which the bar shows a warning."""

BAR_SHARE = 0.2
"""Share of its axes that the bar of a battery takes; the words take the rest."""


class TimeAxis:
    """The horizontal axis of charts up to ``end``: steps, or simulated seconds.

    ``clocks``, ``[S]``, are the seconds at which each step was complete.
    """

    def __init__(self, end: float, clocks: Sequence[float] | None = None) -> None:
        self.end, self._clocks = end, clocks
        self.in_seconds = clocks is not None

    def of_steps(self, last: int) -> list[float]:
        """Return the places of the steps 0 to ``last``."""
        return [*range(last + 1)] if self._clocks is None else [*self._clocks[: last + 1]]

    def of_frame(self, frame: Frame) -> float:
        """Return the place of a frame."""
        return frame.clock if self.in_seconds else frame.progress


class Chart:
    """A chart of a track, whose values its vertical range has room for.

    Attributes:
        title: words above the axes.
        metrics: names of which a track must have one, to be drawn.
        changes_within_steps: true if frames within one step look different.
        scales: axes whose vertical ranges charts of this kind share.
    """

    title = ""
    metrics: ClassVar[tuple[str, ...]] = ()
    changes_within_steps = False

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        self._figure, self._axes, self._time = figure, axes, time
        self.scales: tuple[Axes, ...] = (axes,)
        axes.set_title(self._title(track), fontsize=9, loc="left", color=INK, pad=4)
        room = 0.02 * time.end if time.in_seconds else 0.5
        axes.set_xlim(-room, max(time.end + room, 1))
        axes.xaxis.set_major_locator(MaxNLocator(nbins=8, integer=not time.in_seconds))
        style_chart(axes)
        self._begin(track)

    @classmethod
    def can_draw(cls, track: Track) -> bool:
        """Return whether a track has what the chart shows."""
        return any(name in track.metrics for name in cls.metrics)

    def label_time(self) -> None:
        """Write below the chart what its horizontal axis counts."""
        label = "seconds" if self._time.in_seconds else "step"
        self._axes.set_xlabel(label, fontsize=SMALLEST, labelpad=1)

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of a frame."""
        self._draw(track, self._time.of_steps(track.step_at(frame)))

    def _title(self, _track: Track) -> str:
        return self.title

    def _begin(self, track: Track) -> None:
        """Add what the chart draws, and fit the vertical ranges to a whole track."""

    def _draw(self, track: Track, times: list[float]) -> None:
        """Draw as many steps as there are times."""

    def _line(self, *marker: str, **style: Any) -> Line2D:
        """Return a new line, without points so far."""
        [line] = self._axes.plot([], [], *marker, **style)
        self._figure.add_mover(line)
        return line

    def _area(self, **labels: Any) -> Polygon:
        """Return a new area behind the lines, which has a vertical axis of its own."""
        behind = self._axes.twinx()
        self.scales = (*self.scales, behind)
        behind.set_zorder(self._axes.get_zorder() - 1)
        self._axes.patch.set_visible(False)
        behind.spines[:].set_visible(False)
        behind.tick_params(length=0, **labels)
        behind.yaxis.set_major_locator(MaxNLocator(nbins=3))
        area = Polygon([(0, 0), (0, 0)], closed=True, facecolor=FAINT, linewidth=0)
        self._figure.add_movers(behind, area)
        return area


class RewardChart(Chart):
    """Cumulative reward as a line, the reward of each step as a bar."""

    title = "cumulative reward (bars: each step)"
    metrics = ("rewards",)

    def _begin(self, track: Track) -> None:
        self._axes.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
        self._bars = LineCollection([], colors=[BATTERY], linewidths=1.6, alpha=0.7)
        self._figure.add_movers(self._axes, self._bars)
        self._total = self._line(color=INK, linewidth=1.6)
        self._head = self._line("o", color=INK, markersize=4, clip_on=False)
        self._axes.set_ylim(-1, 1)
        rewards, totals = track.rewards_until(track.steps)
        fit(self._axes, [*rewards, *totals])

    def _draw(self, track: Track, times: list[float]) -> None:
        rewards, totals = track.rewards_until(len(times) - 1)
        fit(self._axes, [*rewards, *totals])
        self._bars.set_segments([[(x, 0.0), (x, r)] for x, r in zip(times, rewards, strict=True)])
        self._total.set_data(times, totals)
        self._head.set_data(times[-1:], totals[-1:])


class DistanceChart(Chart):
    """Manhattan distances to pickup and dropoff; each line ends with its letter."""

    NAMES: ClassVar[dict[str, str]] = {PICKUP: "dist_pickup", DROPOFF: "dist_dropoff"}
    STYLES: ClassVar[dict[str, Any]] = {PICKUP: "-", DROPOFF: (0, (4, 1.5))}
    metrics = tuple(NAMES.values())

    def _title(self, track: Track) -> str:
        stations = (TILES[tile] for tile, name in self.NAMES.items() if name in track.metrics)
        return f"distance to {' and '.join(stations)} (cells)"

    def _begin(self, track: Track) -> None:
        tiles = [tile for tile, name in self.NAMES.items() if name in track.metrics]
        self._axes.set_ylim(-0.5, 1)
        self._lines = {
            tile: self._line(color=COLORS[tile], linestyle=self.STYLES[tile], linewidth=1.8)
            for tile in tiles
        }
        self._letters = {tile: self._letter(tile) for tile in tiles}
        for tile in tiles:
            fit(self._axes, track.metrics[self.NAMES[tile]])

    def _draw(self, track: Track, times: list[float]) -> None:
        for tile, line in self._lines.items():
            distances = track.metrics[self.NAMES[tile]][: len(times)]
            fit(self._axes, distances)
            line.set_data(times, distances)
            here = distances[-1]
            self._letters[tile].set_visible(not math.isnan(here))
            self._letters[tile].set_position((times[-1], 0.0 if math.isnan(here) else here))

    def _letter(self, tile: str) -> Text:
        disc = {"boxstyle": "circle,pad=0.15", "facecolor": COLORS[tile], "linewidth": 0}
        letter = self._axes.text(
            0, 0, tile, fontsize=SMALLEST, fontweight="bold", ha="center", va="center", bbox=disc
        )
        self._figure.add_mover(letter)
        return letter


class MotionChart(Chart):
    """Energy used so far as an area, and the speed of continuous motions as a line."""

    changes_within_steps = True

    @classmethod
    def can_draw(cls, track: Track) -> bool:
        """Return whether a track has speeds, or energy that was used."""
        return track.is_continuous or track.frames[-1].energy > 0

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to a frame."""
        self._fit(track)
        frames = track.frames[: frame + 1]
        times = list(map(self._time.of_frame, frames))
        if track.is_continuous:
            self._speed.set_data(times, [each.speed for each in frames])
        fill(self._energy, times, [each.energy for each in frames])

    def _title(self, track: Track) -> str:
        return f"{'speed (m/s, line), ' if track.is_continuous else ''}energy used (area)"

    def _begin(self, track: Track) -> None:
        self._axes.yaxis.set_visible(track.is_continuous)
        self._energy = self._area(labelsize=SMALLEST, labelcolor="0.35", pad=3)
        self.scales[1].yaxis.set_major_formatter(EngFormatter(unit="J"))
        self._speed = self._line(color=BATTERY, linewidth=1.2)
        for scale in self.scales:
            scale.set_ylim(0, 1)
        self._fit(track)

    def _fit(self, track: Track) -> None:
        fit(self.scales[0], [max(frame.speed for frame in track.frames)])
        fit(self.scales[1], [track.frames[-1].energy])


class DeliveryChart(Chart):
    """Orders released and delivered so far."""

    title = "orders delivered (thin line: released)"
    metrics = ("released", "delivered")

    def _begin(self, track: Track) -> None:
        self._axes.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
        self._lines = {
            name: self._line(color=INK, drawstyle="steps-post", linewidth=width)
            for name, width in zip(self.metrics, (0.8, 2.2), strict=True)
        }
        self._axes.set_ylim(0, 1)
        fit(self._axes, [track.metrics[name][-1] for name in self.metrics])

    def _draw(self, track: Track, times: list[float]) -> None:
        for name, line in self._lines.items():
            line.set_data(times, track.metrics[name][: len(times)])


class LatenessChart(Chart):
    """By how many steps each delivery was late; dots on time, triangles late."""

    title = "lateness of each delivery (steps; ▲ late)"
    metrics = ("delivered",)

    def _begin(self, track: Track) -> None:
        self._axes.axhline(0, color=INK, linewidth=0.8, zorder=0)
        style: dict[str, Any] = {"linestyle": "none", "markeredgewidth": 0}
        self._dots = {
            False: self._line(marker="o", markersize=3.5, color=BATTERY, **style),
            True: self._line(marker="^", markersize=5.5, color=WARNING, **style),
        }
        self._axes.set_ylim(-1, 1)
        fit(self._axes, [late for _, late in track.lateness])

    def _draw(self, track: Track, times: list[float]) -> None:
        lateness = [(step, late) for step, late in track.lateness if step < len(times)]
        for is_late, dots in self._dots.items():
            shown = [(times[step], late) for step, late in lateness if (late > 0) == is_late]
            dots.set_data([x for x, _ in shown], [late for _, late in shown])


class EnergyChart(Chart):
    """The batteries as lines, and the energy used so far as an area with its own scale."""

    title = "battery (%; thin line: lowest) and energy (kJ, area)"
    metrics = ("battery_mean", "battery_lowest")

    def _begin(self, track: Track) -> None:
        self._energy = self._area(labelsize=SMALLEST, labelcolor="0.45", pad=1)
        looks = ((BATTERY, 2.2), (WARNING, 0.9))
        self._lines = {
            name: self._line(color=color, linewidth=width)
            for name, (color, width) in zip(self.metrics, looks, strict=True)
        }
        self._axes.set_ylim(0, 105)
        self.scales[1].set_ylim(0, max(1.0, 1.08e-3 * track.metrics["joules"][-1]))

    def _draw(self, track: Track, times: list[float]) -> None:
        for name, line in self._lines.items():
            line.set_data(times, [100 * share for share in track.metrics[name][: len(times)]])
        fill(self._energy, times, [j / 1000 for j in track.metrics["joules"][: len(times)]])


class BatteryBar:
    """A short bar with the battery level in words; when low it is red and the words warn."""

    changes_within_steps = False
    scales: tuple[Axes, ...] = ()

    def __init__(self, figure: SceneFigure, axes: Axes, _track: Track, _time: TimeAxis) -> None:
        axes.set(xlim=(0, 1 / BAR_SHARE), ylim=(0, 1))
        axes.set_axis_off()
        self._paper = Rectangle((0, 0.2), 1, 0.6, linewidth=0.8, edgecolor=INK, facecolor=PAPER)
        self._bar = Rectangle((0, 0.2), 1, 0.6, linewidth=0)
        figure.add_movers(axes, self._paper, self._bar)
        self._text = axes.text(1.06, 0.47, "", va="center", fontsize=8.5, color=INK)
        figure.add_mover(self._text)

    def show(self, track: Track, frame: int) -> None:
        """Draw the level of ``frame``."""
        level = track.metrics["battery"][track.step_at(frame)]
        known = not math.isnan(level)
        share = min(1.0, max(0.0, level / track.full_battery)) if known else 0.0
        low = known and share < WARNING_SHARE
        self._paper.set(facecolor=PALE_WARNING if low else PAPER, linewidth=1.6 if low else 0.8)
        self._bar.set(width=share, facecolor=WARNING if low else BATTERY)
        warning = "" if not low else "  EMPTY!" if share == 0 else "  LOW!"
        units = f"{level:.10g} of {track.full_battery:.10g}" if known else "unknown"
        self._text.set(
            text=f"battery {units}{warning}",
            fontweight="bold" if low else "normal",
            fontsize=12 if low else 8.5,
        )


def kinds_of_charts(tracks: Sequence[Track]) -> list[type[Chart]]:
    """Return the kinds of charts that at least one of some tracks can fill, from top to bottom."""
    if any(track.counts_orders for track in tracks):
        return [DeliveryChart, LatenessChart, EnergyChart]
    kinds: list[type[Chart]] = [RewardChart, DistanceChart]
    if any(track.is_continuous for track in tracks):
        kinds.append(MotionChart)
    return [kind for kind in kinds if any(map(kind.can_draw, tracks))]


def share_scales(charts: Sequence[Chart | BatteryBar]) -> None:
    """Give charts of one kind the same vertical ranges, which show the values of all."""
    for kind in {type(chart) for chart in charts}:
        same = [chart.scales for chart in charts if type(chart) is kind]
        for scales in zip(*same, strict=True):
            lows, highs = zip(*(axes.get_ylim() for axes in scales), strict=True)
            for axes in scales:
                axes.set_ylim(min(lows), max(highs))


def fill(area: Polygon, times: Sequence[float], heights: Sequence[float]) -> None:
    """Give an area its upper edge; it begins at 0 and ends at the last of some times."""
    area.set_xy([(0.0, 0.0), *zip(times, heights, strict=True), (times[-1], 0.0)])


def fit(axes: Axes, values: Sequence[float]) -> None:
    """Widen the range of ``axes`` to show ``values``; it is never narrowed."""
    low, high = axes.get_ylim()
    known = [value for value in values if not math.isnan(value)]
    least, most = min([low, *known]), max([high, *known])
    margin = 0.08 * (most - least)
    if least < low:
        axes.set_ylim(bottom=least - margin)
    if most > high:
        axes.set_ylim(top=most + margin)
