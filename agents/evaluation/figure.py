"""A figure that compares agents: a panel for each measure, a row for each agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill

from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter, LogLocator, MaxNLocator, NullFormatter, PercentFormatter

from agents.evaluation.interval import Interval
from agents.evaluation.scores import MEASURES, Measure, Scores
from warehouse_core.render.palette import BATTERY, INK, WARNING
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import printable

WIDTH, HEIGHT, ROW_HEIGHT, DPI = 10.0, 2.7, 0.4, 120
"""In inches, the height without and of the rows of agents, and dots per inch."""

MAX_LETTERS, LETTER = 36, 0.0064
"""Of an agent's name, whose beginning may be left out, and their share of the width."""

CAPTION_LETTERS = 165
"""In a line of the caption."""

ROOM = 1.4
"""Factor of space on a logarithmic axis, below the lowest value and above the highest."""


def scores_figure(scores: Mapping[str, Scores], title: str, caption: str = "") -> SceneFigure:
    """Draw the agents' scores, with 95% intervals."""
    names = [_fitting(printable(name)) for name in scores]
    height = HEIGHT + ROW_HEIGHT * len(names)
    figure = make_figure((WIDTH, height), DPI)
    grid = figure.subplots(2, 3, sharey=True)
    figure.subplots_adjust(
        left=0.035 + LETTER * max(map(len, names)), right=0.97, top=1 - 0.78 / height,
        bottom=0.9 / height, wspace=0.12, hspace=0.42,
    )  # fmt: skip
    figure.suptitle(title, x=0.012, y=1 - 0.15 / height, ha="left", fontsize=12, color=INK)
    caption = fill(caption, CAPTION_LETTERS)
    figure.text(0.012, 0.1 / height, caption, fontsize=8, color="0.4", parse_math=False)
    for axes, measure in zip(grid.flat, MEASURES, strict=True):
        _draw(axes, measure, names, [measure.of(each) for each in scores.values()])
    return figure


def _fitting(name: str) -> str:
    return name if len(name) <= MAX_LETTERS else f"\N{HORIZONTAL ELLIPSIS}{name[1 - MAX_LETTERS :]}"


def _draw(
    axes: Axes, measure: Measure, names: Sequence[str], found: Sequence[Interval | None]
) -> None:
    """Draw bars from 0, or points on a logarithmic axis, which has no 0."""
    known = [(place, interval) for place, interval in enumerate(found) if interval is not None]
    for place in set(range(len(found))) - {place for place, _ in known}:
        axes.annotate(
            "no delivery", (0.03, place), xycoords=("axes fraction", "data"), va="center",
            fontsize=8, color="0.4",
        )  # fmt: skip
    for place, interval in known:
        if not measure.is_log:
            axes.barh(place, interval.estimate, 0.62, color=BATTERY)
        else:
            axes.plot(interval.estimate, place, "o", markersize=5.5, color=BATTERY)
        if interval.is_known:
            axes.plot(interval[1:], (place, place), "|-", color=WARNING, linewidth=1.4)
    axes.set_title(measure.title, loc="left", fontsize=9.5, color=INK)
    axes.set_yticks(range(len(names)), names, fontsize=9, parse_math=False)
    axes.set_ylim(len(names) - 0.4, -0.6)
    style_chart(axes, "x")
    if measure.is_log:
        _scale_log(axes, [end for _, interval in known for end in interval if end > 0])
    elif measure is MEASURES[0]:
        axes.xaxis.set_major_formatter(PercentFormatter(1))
        axes.set_xlim(0, 1)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(nbins=5))
        axes.set_xlim(left=0)


def _scale_log(axes: Axes, values: Sequence[float]) -> None:
    low, high = min(values, default=1.0), max(values, default=10.0)
    axes.set_xscale("log")
    axes.set_xlim(low / ROOM, high * ROOM)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    axes.xaxis.set_minor_formatter(NullFormatter())
