"""The charts beside the warehouse: reward, distances, motion and battery."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import ClassVar

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
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
    LineStyle,
)
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.track import Frame, Track
from warehouse_core.world.tiles import DROPOFF, PICKUP, TILES

LOW_BATTERY = 0.2
"""Share of a full battery below which the bar shows a warning."""


class TimeAxis:
    """The horizontal axis of charts: steps, or simulated seconds.

    Args:
        end: the last step or second to leave room for.
        clocks: ``[S]`` the seconds at which each step was complete; ``None`` counts steps.
    """

    def __init__(self, end: float, clocks: Sequence[float] | None = None) -> None:
        self.end, self._clocks = end, clocks
        self.in_seconds = clocks is not None
        self.label = "seconds" if self.in_seconds else "step"

    @classmethod
    def of(cls, track: Track) -> TimeAxis:
        """Return the axis of a complete track: in seconds if its motion is continuous."""
        if track.is_continuous:
            return cls(track.frames[-1].clock, track.clocks)
        return cls(track.steps)

    def of_steps(self, last: int) -> list[float]:
        """Return the places of the steps 0 to ``last``."""
        steps = range(last + 1)
        return [*steps] if self._clocks is None else [self._clocks[step] for step in steps]

    def of_frame(self, frame: Frame) -> float:
        """Return the place of a frame."""
        return frame.clock if self.in_seconds else frame.progress


class RewardChart:
    """Cumulative reward as a line, the reward of each step as a bar."""

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        prepare(axes, "cumulative reward (bars: each step)", time)
        self._axes, self._time, self.scales = axes, time, (axes,)
        axes.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
        self._bars = LineCollection([], colors=[BATTERY], linewidths=1.6, alpha=0.7)
        axes.add_collection(self._bars, autolim=False)
        self._line = axes.plot([], [], color=INK, linewidth=1.6)[0]
        self._head = axes.plot([], [], "o", color=INK, markersize=4, clip_on=False)[0]
        for mover in (self._bars, self._line, self._head):
            figure.add_mover(mover)
        axes.set_ylim(-1, 1)
        rewards, totals = _rewards(track, track.steps + 1)
        fit(axes, [*rewards, *totals])

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of ``frame``."""
        last = track.step_at(frame)
        rewards, totals = _rewards(track, last + 1)
        fit(self._axes, [*rewards, *totals])
        times = self._time.of_steps(last)
        self._bars.set_segments([[(x, 0.0), (x, r)] for x, r in zip(times, rewards, strict=True)])
        self._line.set_data(times, totals)
        self._head.set_data(times[-1:], totals[-1:])


class DistanceChart:
    """Manhattan distances to pickup and dropoff; each line ends with its letter."""

    NAMES: ClassVar[dict[str, str]] = {PICKUP: "dist_pickup", DROPOFF: "dist_dropoff"}
    STYLES: ClassVar[dict[str, LineStyle]] = {PICKUP: "-", DROPOFF: (0, (4, 1.5))}

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        self._axes, self._time, self.scales = axes, time, (axes,)
        self._tiles = [tile for tile, name in self.NAMES.items() if name in track.metrics]
        stations = " and ".join(TILES[tile] for tile in self._tiles)
        prepare(axes, f"distance to {stations} (cells)", time)
        axes.set_ylim(-0.5, 1)
        self._lines = {
            tile: axes.plot([], [], color=COLORS[tile], linestyle=self.STYLES[tile], linewidth=1.8)[
                0
            ]
            for tile in self._tiles
        }
        self._letters = {tile: self._letter(tile) for tile in self._tiles}
        for mover in (*self._lines.values(), *self._letters.values()):
            figure.add_mover(mover)
        for tile in self._tiles:
            fit(axes, track.metrics[self.NAMES[tile]])

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to the last complete step of ``frame``."""
        last = track.step_at(frame)
        times = self._time.of_steps(last)
        for tile in self._tiles:
            distances = track.metrics[self.NAMES[tile]][: last + 1]
            fit(self._axes, distances)
            self._lines[tile].set_data(times, distances)
            here = distances[-1]
            self._letters[tile].set_visible(not math.isnan(here))
            self._letters[tile].set_position((times[-1], 0.0 if math.isnan(here) else here))

    def _letter(self, tile: str) -> Text:
        disc = {"boxstyle": "circle,pad=0.15", "facecolor": COLORS[tile], "linewidth": 0}
        return self._axes.text(
            0, 0, tile, fontsize=8, fontweight="bold", ha="center", va="center", bbox=disc
        )


class MotionChart:
    """Energy used so far as an area, and the speed of continuous motions as a line."""

    def __init__(self, figure: SceneFigure, axes: Axes, track: Track, time: TimeAxis) -> None:
        speed = "speed (m/s, line), " if track.is_continuous else ""
        prepare(axes, f"{speed}energy used (area)", time)
        axes.yaxis.set_visible(track.is_continuous)
        self._axes, self._energy_axes, self._time = axes, axes.twinx(), time
        self.scales = (self._axes, self._energy_axes)
        self._energy_axes.set_zorder(axes.get_zorder() - 1)
        axes.patch.set_visible(False)
        self._energy_axes.spines[:].set_visible(False)
        self._energy_axes.tick_params(labelsize=8, labelcolor="0.35", length=0, pad=3)
        self._energy_axes.yaxis.set_major_locator(MaxNLocator(nbins=3))
        self._energy_axes.yaxis.set_major_formatter(EngFormatter(unit="J"))
        self._area = Polygon([(0, 0), (0, 0)], closed=True, facecolor=FAINT, linewidth=0)
        self._energy_axes.add_patch(self._area)
        self._line = axes.plot([], [], color=BATTERY, linewidth=1.2)[0]
        for mover in (self._area, self._line):
            figure.add_mover(mover)
        axes.set_ylim(0, 1)
        self._energy_axes.set_ylim(0, 1)
        self._fit(track)

    def show(self, track: Track, frame: int) -> None:
        """Draw everything up to ``frame``."""
        self._fit(track)
        frames = track.frames[: frame + 1]
        times = list(map(self._time.of_frame, frames))
        if track.is_continuous:
            self._line.set_data(times, [each.speed for each in frames])
        edge = [(x, each.energy) for x, each in zip(times, frames, strict=True)]
        self._area.set_xy([(0.0, 0.0), *edge, (times[-1], 0.0)])

    def _fit(self, track: Track) -> None:
        fit(self._axes, [max(frame.speed for frame in track.frames)])
        fit(self._energy_axes, [track.frames[-1].energy])


class BatteryBar:
    """A short bar with the battery level in words; when low it is red and the words warn.

    Args:
        figure: to add the movers to.
        axes: as wide as the bar and the words.
        length: share of the width that the bar takes.
    """

    def __init__(self, figure: SceneFigure, axes: Axes, length: float = 0.2) -> None:
        axes.set(xlim=(0, 1 / length), ylim=(0, 1))
        axes.set_axis_off()
        self._paper = axes.add_patch(
            Rectangle((0, 0.2), 1, 0.6, linewidth=0.8, edgecolor=INK, facecolor=PAPER)
        )
        self._bar = axes.add_patch(Rectangle((0, 0.2), 1, 0.6, linewidth=0))
        self._text = axes.text(1.06, 0.47, "", va="center", fontsize=8.5, color=INK)
        for mover in (self._paper, self._bar, self._text):
            figure.add_mover(mover)

    def show(self, track: Track, frame: int) -> None:
        """Draw the level of ``frame``."""
        level = track.metrics["battery"][track.step_at(frame)]
        known = not math.isnan(level)
        share = min(1.0, max(0.0, level / track.full_battery)) if known else 0.0
        low = known and share < LOW_BATTERY
        self._paper.set(facecolor=PALE_WARNING if low else PAPER, linewidth=1.6 if low else 0.8)
        self._bar.set(width=share, facecolor=WARNING if low else BATTERY)
        warning = "" if not low else "  EMPTY!" if share == 0 else "  LOW!"
        units = f"{level:.10g} of {track.full_battery:.10g}" if known else "unknown"
        self._text.set(
            text=f"battery {units}{warning}",
            fontweight="bold" if low else "normal",
            fontsize=12 if low else 8.5,
        )


def prepare(axes: Axes, title: str, time: TimeAxis) -> None:
    """Give a chart its title and its horizontal axis."""
    axes.set_title(title, fontsize=9, loc="left", color=INK, pad=4)
    room = 0.02 * time.end if time.in_seconds else 0.5
    axes.set_xlim(-room, max(time.end + room, 1))
    axes.xaxis.set_major_locator(MaxNLocator(nbins=8, integer=not time.in_seconds))
    style_chart(axes)


def _rewards(track: Track, count: int) -> tuple[list[float], list[float]]:
    """Return the first ``count`` rewards, with NaN as 0, and their running sums."""
    rewards = [0.0 if math.isnan(r) else r for r in track.metrics["rewards"][:count]]
    return rewards, list(accumulate(rewards))


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
