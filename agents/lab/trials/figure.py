"""Charts of measures with their intervals: the panels of all charts, and comparisons.

A panel is as wide as a phone, where its text is 12 CSS pixels high; a desktop shows it larger.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from textwrap import wrap
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter, PercentFormatter

from agents.lab.trials.interval import Interval
from agents.lab.trials.scores import MEASURES, Measure, Scores
from warehouse_core.render.palette import INK, SERIES
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import printable

WIDTH, PANEL_HEIGHT, FOOT, DPI, PIXELS = 3.4, 2.6, 0.45, 100, 150
"""Width, height of a panel and space below the last panel, in inches, dots per inch of figures on
pages, and of comparisons, which may be saved as pixels."""

LEFT, RIGHT, ROW, LETTERS = 0.6, 0.12, 0.2, 12.0
"""Margins left and right of the panels, line height of title and legend, in inches, and number of
letters of a chart's text that fit into an inch."""

MAX_TICKS, MAX_LETTERS = 10, 20
"""Maximum number of names along an axis, and maximum number of letters in each."""

MEASURE_WIDTH, ROW_HEIGHT, ROW_LETTERS = 2.9, 0.3, 36
"""Width of a panel of a comparison and height of a row in inches, and maximum number of letters in
the name of a row."""

TITLE_SIZE, TEXT_SIZE = 11.0, 9.0
"""Text sizes in points; the smaller one is 12 CSS pixels if a panel is ``WIDTH`` inches wide."""

SMALL: dict[str, Any] = {"fontsize": TEXT_SIZE, "color": INK}

MARKERS = "os^Dv*PX"

BOUND: dict[str, Any] = {"color": "0.45", "linestyle": "--", "linewidth": 1.6}
"""Look of a curve without intervals that no other one can exceed."""


def make_panels(
    title: str,
    panels: Sequence[str],
    labels: Sequence[str],
    axis: str,
    places: Mapping[str, float],
    columns: int = 1,
) -> tuple[SceneFigure, list[Axes]]:
    """Return a figure with panels over one axis, and space for a legend.

    At most ``MAX_TICKS`` names are below the axis, upright if they do not fit side by side. Panels
    in a single column have the same scale.

    Args:
        title: title of the figure.
        panels: titles of the panels.
        labels: labels of the legend.
        axis: label of the axis.
        places: place of each name along the axis.
        columns: number of columns of panels.
    """
    step, wide, rows = ceil(len(places) / MAX_TICKS), columns * WIDTH, ceil(len(panels) / columns)
    names = [shortened(name, MAX_LETTERS) for name in list(places)[::step]]
    is_upright = sum(len(name) + 1 for name in names) > int((WIDTH - LEFT - RIGHT) * LETTERS)
    above = ROW * (len(_lines(title, wide)) + ceil(len(labels) / _legend_columns(labels, wide)))
    foot = FOOT + (max(map(len, names)) / LETTERS if is_upright else 0.0)
    height = above + rows * PANEL_HEIGHT + foot
    figure = make_figure((wide, height), DPI)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=columns == 1)
    figure.subplots_adjust(
        left=LEFT / wide, right=1 - RIGHT / wide, top=1 - (above + 0.4) / height,
        bottom=foot / height, hspace=0.25,
    )  # fmt: skip
    _write_title(figure, title)
    for axes, words in zip(grid.flat, panels, strict=True):
        _style(axes, words, "y")
    for axes in grid[-1]:
        axes.set_xticks(list(places.values())[::step], names, rotation=90 if is_upright else 0)
        axes.set_xlabel(axis, **SMALL)
    return figure, list(grid.flat)


def shortened(name: str, letters: int) -> str:
    """Return a name with at most this many letters, shortened in the middle."""
    half = letters // 2
    ends = name[: half - 1], name[-half:]
    return name if len(name) <= letters else "\N{HORIZONTAL ELLIPSIS}".join(ends)


def _lines(title: str, wide: float) -> list[str]:
    """Return the lines of a title above a figure of this width in inches."""
    return wrap(title, int(wide * 9))


def _write_title(figure: SceneFigure, title: str) -> None:
    wide, height = figure.get_size_inches()
    figure.suptitle(
        "\n".join(_lines(title, wide)), x=0.03 * WIDTH / wide, y=1 - 0.08 / height, ha="left",
        va="top", fontsize=TITLE_SIZE, color=INK, parse_math=False,
    )  # fmt: skip


def _style(axes: Axes, title: str, grid: Literal["x", "y"]) -> None:
    """Give a panel its title, and lines across the axis ``grid``."""
    style_chart(axes, grid)
    axes.tick_params(labelsize=TEXT_SIZE, labelcolor=INK, color=INK)
    axes.set_title(title, loc="left", **SMALL)


def draw_legend(figure: SceneFigure, title: str, keys: Mapping[str, Any]) -> None:
    """Draw the legend, given as marks by their labels, below the title."""
    wide = figure.get_figwidth()
    below = 0.1 + ROW * len(_lines(title, wide))
    figure.legend(
        list(keys.values()), list(keys), loc="upper left",
        ncols=_legend_columns(list(keys), wide),
        bbox_to_anchor=(0, 1 - below / figure.get_figheight()), frameon=False, labelcolor=INK,
        fontsize=TEXT_SIZE, columnspacing=1.0, handletextpad=0.5, labelspacing=0.3,
    )  # fmt: skip


def _legend_columns(labels: Sequence[str], wide: float) -> int:
    longest = max(map(len, labels), default=0) + 5
    return max(int(wide * LETTERS) // longest, 1)


def draw_line(
    axes: Axes, points: Mapping[float, Interval], number: int, line: str = "-", along: str = "x"
) -> Any:
    """Draw points with intervals in the colour of a number, and return the mark for the legend.

    The keys of ``points`` are the places ``along`` the axis x or y.
    """
    middle, low, high = zip(*points.values(), strict=True)
    reach = [
        [one - other for one, other in zip(middle, low, strict=True)],
        [other - one for one, other in zip(middle, high, strict=True)],
    ]
    look: dict[str, Any] = {"color": SERIES[number % len(SERIES)], "linewidth": 1.6}
    look |= {"linestyle": line, "fmt": MARKERS[number % len(MARKERS)], "markersize": 5}
    if along == "y":
        return axes.errorbar(middle, list(points), xerr=reach, capsize=3, **look)
    return axes.errorbar(list(points), middle, reach, capsize=3, **look)


def scale_axis(axes: Axes, unit: str, *, along: str = "y", is_log: bool = False) -> None:
    """Let the axis of a measure begin at 0, show a share as percent, or make it logarithmic."""
    axis: Axis = getattr(axes, f"{along}axis")
    if is_log:
        axes.set(**{f"{along}scale": "log"})
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)))
        axis.set_major_formatter(EngFormatter(sep=""))
        axis.set_minor_formatter(NullFormatter())
    elif unit == "%":
        axis.set_major_formatter(PercentFormatter(1))
        axes.set(**{f"{along}lim": (-0.02, 1.02)})
    else:
        axes.set(**{f"{along}lim": (0, None)})
        axis.set_label_text(unit, **SMALL)


@mpl.rc_context({"text.parse_math": False})
def scores_figure(
    groups: Mapping[str, Mapping[str, Scores]],
    measures: Sequence[Measure] = MEASURES,
    caption: str = "",
) -> SceneFigure:
    """Draw the scores of the same agents in one or several tasks, with a panel for each measure.

    Each agent has a row, so that long names can be read.
    """
    titles = list(map(printable, groups))
    names = [shortened(printable(name), ROW_LETTERS) for name in next(iter(groups.values()))]
    title, labels = titles[0], list[str]()
    if len(titles) > 1:  # the tasks differ in the first part of their titles
        title, labels = title.partition(", ")[2], [each.partition(", ")[0] for each in titles]
    columns, margin = 3 if len(measures) > 4 else 2, max(map(len, names)) / LETTERS + 0.3
    rows, wide = ceil(len(measures) / columns), margin + columns * MEASURE_WIDTH
    high, lines = 0.7 + ROW_HEIGHT * len(names), wrap(caption, int(wide * LETTERS))
    above = 0.5 + ROW * (1 + ceil(len(labels) / _legend_columns(labels, wide)))
    foot = 0.2 + ROW * len(lines)
    height = above + rows * high + foot
    figure = make_figure((wide, height), PIXELS)
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
    figure.subplots_adjust(
        left=margin / wide, right=1 - RIGHT / wide, top=1 - above / height,
        bottom=(foot + 0.4) / height, hspace=0.7 / (high - 0.7), wspace=0.12,
    )  # fmt: skip
    _write_title(figure, title)
    figure.text(0.1 / wide, 0.1 / height, "\n".join(lines), **SMALL)
    keys: dict[int, Any] = {}
    for axes, measure in zip(grid.flat, measures, strict=False):
        for number, scores in enumerate(groups.values()):
            shift = 0.2 * (number - (len(groups) - 1) / 2)
            found = [measure.of(each) for each in scores.values()]
            points = {place + shift: each for place, each in enumerate(found) if each}
            if points:
                keys.setdefault(number, draw_line(axes, points, number, "", "y"))
        _style(axes, measure.title, "x")
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        scale_axis(axes, "%" * (measure is MEASURES[0]), along="x", is_log=measure.is_log)
    for axes in list(grid.flat)[len(measures) :]:
        axes.remove()
    if labels:
        draw_legend(figure, title, {label: keys[number] for number, label in enumerate(labels)})
    return figure


@mpl.rc_context({"text.parse_math": False})
def curves_figure(
    curves: Mapping[str, Mapping[int, Interval]], title: str, measure: str, bound: str = ""
) -> SceneFigure:
    """Draw curves of a measure over the number of robots, with 95% intervals.

    The curve called ``bound`` is dashed and has no intervals.
    """
    places = {str(size): float(size) for curve in curves.values() for size in curve}
    figure, [axes] = make_panels(title, [measure], list(curves), "robots", places)
    keys: dict[str, Any] = {}
    for number, (name, curve) in enumerate(curves.items()):
        means = [each.estimate for each in curve.values()]
        if name == bound:
            [keys[name]] = axes.plot(list(curve), means, **BOUND)
        else:
            points = {float(size): each for size, each in curve.items()}
            keys[printable(name)] = draw_line(axes, points, number)
    scale_axis(axes, "")
    draw_legend(figure, title, keys)
    figure.set_dpi(PIXELS)
    return figure
