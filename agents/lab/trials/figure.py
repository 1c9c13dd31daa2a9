"""Figures that compare agents by several measures, and planners by the number of robots."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from math import ceil
from textwrap import fill
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter, LogLocator, MaxNLocator, NullFormatter, PercentFormatter

from agents.lab.trials.interval import Interval
from agents.lab.trials.scores import MEASURES, Measure, Scores
from warehouse_core.render.palette import INK, SERIES
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import printable

WIDTH, ROW_HEIGHT, DPI, GREY = 11.5, 0.4, 110, "0.35"
"""Width of the figure and height of a row in inches, dots per inch, and colour of small text."""

COLUMNS, TITLE, ABOVE, BELOW, FOOT = 3, 0.3, 0.42, 0.5, 0.55
"""Number of panels in a line, and heights in inches of a title, of the space above and below a line
of panels, and of the caption."""

MAX_LETTERS, LETTER = 36, 0.0068
"""Maximum length of an agent's name in letters, and width of a letter as a share of the figure."""

CAPTION_LETTERS, ROOM = 165, 1.4
"""Number of letters in a line of the caption, and factor by which a logarithmic axis extends below
the lowest value and above the highest."""

CURVES_SIZE, CURVES_DPI, MARKERS = (8.0, 4.6), 150, "osD^vPX*"
"""Size in inches and dots per inch of a figure of curves, and the markers of its lines."""


def scores_figure(
    groups: Mapping[str, Mapping[str, Scores]],
    caption: str = "",
    measures: Sequence[Measure] = MEASURES,
) -> SceneFigure:
    """Draw the scores of the same agents in one or several tasks, with 95% intervals.

    Each task has a title, a panel for each measure, and in each panel a row for each agent.
    """
    names = [fitting(name) for name in next(iter(groups.values()))]
    rows, high = ceil(len(measures) / COLUMNS), ROW_HEIGHT * len(names)
    line = ABOVE + high + BELOW
    height = len(groups) * (TITLE + rows * line) + FOOT
    figure = make_figure((WIDTH, height), DPI)
    left = 0.035 + LETTER * max(map(len, names))
    wide = (0.965 - left) / COLUMNS
    top = height - 0.12
    for title, scores in groups.items():
        figure.text(
            0.012, top / height, title, fontsize=11, fontweight="bold", color=INK, va="top",
            parse_math=False,
        )  # fmt: skip
        for number, measure in enumerate(measures):
            row, column = divmod(number, COLUMNS)
            bottom = top - TITLE - row * line - ABOVE - high
            box = left + column * wide, bottom / height, 0.84 * wide, high / height
            axes = figure.add_axes(box)
            draw_measure(axes, measure, {name: measure.of(each) for name, each in scores.items()})
            axes.set_yticks(range(len(names)), names, fontsize=10, parse_math=False)
            axes.tick_params(axis="y", labelleft=not column, labelsize=10)
        top -= TITLE + rows * line
    words = fill(caption, CAPTION_LETTERS)
    figure.text(0.012, 0.1 / height, words, fontsize=9, color=GREY, parse_math=False)
    return figure


def fitting(name: str) -> str:
    """Return an agent's name on one line, shortened at the beginning to ``MAX_LETTERS``."""
    name = printable(name)
    return name if len(name) <= MAX_LETTERS else f"\N{HORIZONTAL ELLIPSIS}{name[1 - MAX_LETTERS :]}"


def draw_measure(axes: Axes, measure: Measure, found: Mapping[str, Interval | None]) -> None:
    """Draw a measure as a point with its interval for each agent, or "no delivery"."""
    for place, interval in enumerate(found.values()):
        if interval is None:
            axes.annotate(
                "no delivery", (0.03, place), xycoords=("axes fraction", "data"), va="center",
                fontsize=9, color=GREY,
            )  # fmt: skip
        else:
            axes.errorbar(
                interval.estimate, place, xerr=reach([interval]), fmt="o", capsize=3, markersize=5,
                linewidth=1.6, color=SERIES[0],
            )  # fmt: skip
    axes.set_title(measure.title, loc="left", fontsize=10, color=INK)
    axes.set_ylim(len(found) - 0.4, -0.6)
    style_chart(axes, "x")
    axes.tick_params(axis="x", labelsize=9)
    if measure.is_log:
        ends = [end for interval in found.values() if interval for end in interval if end > 0]
        low, high = min(ends, default=1.0), max(ends, default=10.0)
        axes.set_xscale("log")
        axes.set_xlim(low / ROOM, high * ROOM)
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)))
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.xaxis.set_minor_formatter(NullFormatter())
    elif measure is MEASURES[0]:
        axes.xaxis.set_major_formatter(PercentFormatter(1))
        axes.set_xlim(-0.02, 1.02)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(nbins=5))
        axes.set_xlim(left=0)


def curves_figure(
    curves: Mapping[str, Mapping[int, Interval]], title: str, measure: str, bound: str = ""
) -> SceneFigure:
    """Draw curves of a measure over the number of robots, with 95% intervals.

    The curve called ``bound`` is dashed and has no intervals.
    """
    figure = make_figure(CURVES_SIZE, CURVES_DPI)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.075, right=0.975, top=0.9, bottom=0.125)
    figure.suptitle(title, x=0.02, y=0.975, ha="left", fontsize=11, color=INK, parse_math=False)
    for number, (name, curve) in enumerate(curves.items()):
        look: dict[str, Any] = {"color": SERIES[number % len(SERIES)], "linewidth": 1.6}
        means = [each.estimate for each in curve.values()]
        if name == bound:
            axes.plot(list(curve), means, "--", label=name, **look | {"color": "0.45"})
            continue
        axes.errorbar(
            list(curve), means, reach(curve.values()), fmt=f"-{MARKERS[number % len(MARKERS)]}",
            capsize=3, markersize=5, label=printable(name), **look,
        )  # fmt: skip
    axes.set_xlabel("robots", fontsize=9.5, color=INK)
    axes.set_ylabel(measure, fontsize=9.5, color=INK)
    axes.set_ylim(bottom=0)
    axes.set_xticks(list(next(iter(curves.values()))))
    style_chart(axes)
    for text in axes.legend(fontsize=9, framealpha=1, edgecolor="none").get_texts():
        text.set_parse_math(False)
    return figure


def reach(intervals: Collection[Interval]) -> list[list[float]]:
    """Return the distances from the estimates to the ends of their intervals, for error bars."""
    return [
        [each.estimate - each.low for each in intervals],
        [each.high - each.estimate for each in intervals],
    ]
