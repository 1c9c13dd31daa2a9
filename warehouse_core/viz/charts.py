"""Charts next to the floor in a window or a picture, drawn with matplotlib.

They show the same series as a page. A chart always shows the whole track; the part after the
present frame is pale.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from warehouse_core.render.palette import FAINT, INK, color_named
from warehouse_core.viz.axes import SMALLEST, style_chart
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.line_of_text import LineOfText
from warehouse_core.viz.shapes import BAR, Shape, Shapes, line_width, lines, polygons
from warehouse_core.viz.tracks.series import Series, SeriesKind, series_of
from warehouse_core.viz.tracks.track import Track

WARNING_SHARE = 0.2
"""Share of a full battery below which the bar shows a warning."""

BAR_SHARE = 0.2
"""Share of its axes that the bar of a battery takes; the text takes the rest."""

NARROW = 1.5
"""Width in inches below which a chart has a short title and few numbers below it."""

VEIL = 0.75
"""Opacity of the layer over the part of a chart after the present frame."""

STRIPS = 24
"""Number of strips in which this layer is taken away."""

STYLES: dict[tuple[SeriesKind, int], tuple[str, dict[str, Any]]] = {
    ("line", 0): ("", {"linewidth": 1.8}),
    ("line", 1): ("dashed", {"linewidth": 1.8, "linestyle": (0, (4, 1.5))}),
    ("thin", 0): ("thin", {"linewidth": 0.9, "drawstyle": "steps-post"}),
    ("steps", 0): ("", {"linewidth": 2.2, "drawstyle": "steps-post"}),
    ("bars", 0): ("bars", {"linewidth": 1.6, "solid_capstyle": "butt"}),
    ("dots", 0): ("●", {"linestyle": "none", "marker": "o", "markersize": 3.5, "mew": 0}),
    ("dots", 1): ("▲", {"linestyle": "none", "marker": "^", "markersize": 5.5, "mew": 0}),
}
"""Description of a series in the title of its chart, and its style. Keys are the kind of the series
and how many of this kind precede it in the same chart, so that they differ not only in colour."""

Charted = dict[str, list[Series]]
"""The series of each chart, by its title."""


def charts_of(track: Track, times: Sequence[float]) -> Charted:
    """Return the series of a track, grouped by the title of their chart, from top to bottom."""
    grouped = groupby(series_of(track, times), key=lambda series: series.chart)
    return {title: [*series] for title, series in grouped}


class Chart:
    """A chart of one or more series up to the time ``end``. Its vertical range never shrinks."""

    def __init__(
        self,
        figure: SceneFigure,
        axes: Axes,
        series: Sequence[Series],
        end: float,
        *,
        label: str | None = None,
    ) -> None:
        self.axes, self.title = axes, series[0].chart
        looks = [*_looks(series)]
        names = [
            f"{each.name} ({words})" if words else each.name
            for each, (words, _) in zip(series, looks, strict=True)
        ]
        is_narrow = axes.get_position().width * figure.get_figwidth() < NARROW
        parts = [self.title, ", ".join(names)]
        title = ": ".join(parts[: 1 if is_narrow else len(series)])
        axes.set_title(title, fontsize=9, loc="left", color=INK, pad=4)
        room = 0.02 * end
        axes.set(xlim=(-room, max(end + room, 1)), ylim=(0, 1e-9))
        axes.xaxis.set_major_locator(
            MaxNLocator(nbins=2 if is_narrow else 8, integer=label == "step")
        )
        counts = any(each.kind == "steps" for each in series)  # half an order does not exist
        axes.yaxis.set_major_locator(MaxNLocator(nbins=4, integer=counts))
        if series[0].steps:
            axes.yaxis.set_major_formatter(lambda steps, _: in_time(steps))
        style_chart(axes)
        axes.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
        if label is None:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel(label, fontsize=SMALLEST, labelpad=1)
        self._lines = [
            axes.plot([], [], color=color_named(each.color), **style)[0]
            for each, (_, style) in zip(series, looks, strict=True)
        ]
        self._curtain = Shapes(zorder=3)
        self._strip = max(end, 1) / STRIPS
        self._shown: tuple[float, float, float] | None = None
        for line in self._lines:
            figure.add_mover(line)
        figure.add_movers(axes, self._curtain)
        self.read(series)

    def read(self, series: Sequence[Series]) -> None:
        """Draw these series, which may be longer than before, and extend the range if needed."""
        for line, each in zip(self._lines, series, strict=True):
            line.set_data(*_points(each))
        fit(self.axes, [value for each in series for value in each.values])

    def show(self, time: float) -> None:
        """Make the part after a time pale."""
        column = round(self.axes.transData.transform((time, 0))[0])
        low, high = self.axes.get_ylim()
        if self._shown == (column, low, high):
            return
        self._shown = column, low, high
        end = self.axes.get_xlim()[1]
        # The layer has two parts, and the second one changes only when the first one has gone.
        edge = math.ceil(time / self._strip) * self._strip
        veil = polygons(
            [
                [(left, low), (right, low), (right, high), (left, high)]
                for left, right in ((time, min(edge, end)), (min(edge, end), end))
            ]
        )
        cursor = lines([[(time, low), (time, high)]])
        width = line_width(self.axes, 0.8)
        self._curtain.show([Shape(veil, "paper", alpha=VEIL), Shape(cursor, None, "ink", width)])


def in_time(steps: float) -> str:
    """Return a number of steps after a deadline in words, without a sign."""
    return f"{abs(steps):,.10g} {'late' if steps > 0 else 'early'}" if steps else "on time"


def _looks(series: Iterable[Series]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield for each series of a chart its description in the title, and its style."""
    kinds: list[SeriesKind] = []
    for each in series:
        yield STYLES[each.kind, kinds.count(each.kind)]
        kinds.append(each.kind)


def _points(series: Series) -> tuple[Any, Any]:
    """Return the points of a line. Bars are vertical lines from 0 to their values, with gaps."""
    times, values = np.asarray(series.times, float), np.asarray(series.values, float)
    if series.kind != "bars":
        return times, values
    gap = np.full_like(values, math.nan)
    return times.repeat(3), np.column_stack([0 * values, values, gap]).ravel()


class BatteryBar:
    """A short bar with the battery level as text. When low, the bar is red and the text warns."""

    def __init__(self, figure: SceneFigure, axes: Axes) -> None:
        self._axes = axes
        axes.set(xlim=(0, 1 / BAR_SHARE), ylim=(0, 1))
        axes.set_axis_off()
        self._bar = Shapes()
        self._text = LineOfText(1.06, 0.47, va="center", color=INK, parse_math=False)
        figure.add_movers(axes, self._bar, self._text)
        self._level: float | None = None

    def show(self, track: Track, frame: int) -> None:
        """Draw the level of ``frame``."""
        level = track.metrics["battery"][track.step_at(frame)]
        if level == self._level:
            return
        self._level = level
        known = not math.isnan(level)
        share = min(1.0, max(0.0, level / track.full_battery)) if known else 0.0
        low = known and share < WARNING_SHARE
        rim = line_width(self._axes, 1.6 if low else 0.8)
        whole, filled = (polygons([BAR * (width, 0.6) + (0, 0.2)]) for width in (1, share))
        paper, color = ("pale-warning", "warning") if low else ("paper", "battery")
        self._bar.show([Shape(whole, paper, "ink", rim), Shape(filled, color)])
        warning = "" if not low else "  EMPTY!" if share == 0 else "  LOW!"
        units = f"{level:.10g} of {track.full_battery:.10g}" if known else "unknown"
        self._text.set(
            text=f"battery {units}{warning}",
            fontweight="bold" if low else "normal",
            fontsize=12 if low else 8.5,
        )


def share_scales(charts: Iterable[Chart]) -> None:
    """Give charts with the same title the same vertical range, wide enough for all of them."""
    by_title: dict[str, list[Axes]] = {}
    for chart in charts:
        by_title.setdefault(chart.title, []).append(chart.axes)
    for same in by_title.values():
        for axes in same:
            fit(axes, [limit for each in same for limit in each.get_ylim()], margin=0)


def fit(axes: Axes, values: Sequence[float], margin: float = 0.08) -> None:
    """Widen the vertical range of ``axes`` to show ``values`` with a margin; it never shrinks."""
    low, high = axes.get_ylim()
    known = [value for value in values if not math.isnan(value)]
    least, most = min([low, *known]), max([high, *known])
    room = margin * (most - least)
    if least < low:
        axes.set_ylim(bottom=least - room)
    if most > high:
        axes.set_ylim(top=most + room)
