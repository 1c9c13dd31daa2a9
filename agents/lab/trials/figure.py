"""Figures that compare agents, with a panel for each measure and a row for each agent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import ceil
from textwrap import fill, wrap
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter, LogLocator, MaxNLocator, NullFormatter, PercentFormatter

from agents.lab.trials.interval import Interval
from agents.lab.trials.scores import MEASURES, Measure, Scores
from warehouse_core.render.palette import BATTERY, INK, PALE_WARNING, SERIES, WARNING
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import counted, listed, printable

WIDTH, ROW_HEIGHT, DPI = 11.5, 0.4, 110
"""Width of the figure and height of a row in inches, and dots per inch."""

MESSAGE_LETTERS, LINE, MAX_BEST = 76, 0.26, 4
"""Letters in a line of the message, line height in inches, and most agents named as the best."""

MAX_LETTERS, LETTER = 36, 0.0068
"""Maximum length of an agent's name in letters, and width of a letter as a share of the figure."""

CAPTION_LETTERS = 165
"""Number of letters in a line of the caption."""

BAR, GREY = 0.62, "0.35"
"""Height of a bar as a share of its row, and colour of explanatory text."""

ROOM = 1.4
"""Factor by which a logarithmic axis extends below the lowest value and above the highest."""

COLUMNS, RIGHT, GAP = 3, 0.965, 0.055
"""Number of panels in a line, their right end, and the gap between two as shares of the width."""

TITLE, ABOVE, BELOW, FOOT = 0.3, 0.42, 0.5, 0.55
"""Heights in inches of a title, of the space above and below a line of panels, and of the
caption."""

CURVES_SIZE, CURVES_DPI, MARKERS = (8.0, 4.6), 150, "osD^vPX*"
"""Size in inches and dots per inch of a figure of curves, and the markers of its lines."""


def message(scores: Mapping[str, Scores]) -> str:
    """Return a sentence that names the agents with most deliveries and their steps per delivery."""
    delivered = {name: int(each.delivered.sum()) for name, each in scores.items()}
    total, most = len(next(iter(scores.values())).rows), max(delivered.values())
    if most == 0:
        return f"No agent delivered in {counted(total, 'episode')}"
    best = [name for name in scores if delivered[name] == most]
    names = listed(map(fitting, best)) if len(best) <= MAX_BEST else f"{len(best)} agents"
    found = [scores[name].per_delivery("steps") for name in best]
    steps = sorted(round(each.estimate) for each in found if each)
    cost = " to ".join(dict.fromkeys(f"{each:,}" for each in (steps[0], steps[-1])))
    share = f"All {total:,}" if most == total else f"Most, {most:,} of {total:,},"
    return f"{share} delivered by {names}, at {cost} steps per delivery"


def scores_figure(
    groups: Mapping[str, Mapping[str, Scores]],
    caption: str = "",
    measures: Sequence[Measure] = MEASURES,
) -> SceneFigure:
    """Draw the scores of the same agents in one or several tasks, with 95% intervals.

    The panels of each task have a message with the result, and the title of the task, above them.
    """
    messages = [wrap(message(scores), MESSAGE_LETTERS) for scores in groups.values()]
    agents = len(next(iter(groups.values())))
    panels = ABOVE + ROW_HEIGHT * agents + BELOW
    rows = ceil(len(measures) / COLUMNS)
    heights = [LINE * len(lines) + TITLE + rows * panels for lines in messages]
    figure = make_figure((WIDTH, sum(heights) + FOOT), DPI)
    inch, top = 1 / figure.get_figheight(), sum(heights) + FOOT - 0.12
    style: dict[str, Any] = {"ha": "left", "va": "top", "parse_math": False}
    for (title, scores), lines, height in zip(groups.items(), messages, heights, strict=True):
        below, words = top - LINE * len(lines), "\n".join(lines)
        figure.text(0.012, top * inch, words, fontsize=15, fontweight="bold", color=INK, **style)
        figure.text(0.012, below * inch, title, fontsize=10, color=GREY, **style)
        _draw_panels(figure, below - TITLE, scores, measures)
        top -= height
    words = fill(caption, CAPTION_LETTERS)
    figure.text(0.012, 0.1 * inch, words, fontsize=9, color=GREY, parse_math=False)
    return figure


def _draw_panels(
    figure: SceneFigure, top: float, scores: Mapping[str, Scores], measures: Sequence[Measure]
) -> None:
    """Draw a panel for each measure below ``top``, which is in inches from the bottom."""
    inch, names = 1 / figure.get_figheight(), list(map(fitting, scores))
    left = 0.035 + LETTER * max(map(len, names))
    width = (RIGHT - left - GAP * (COLUMNS - 1)) / COLUMNS
    height = ROW_HEIGHT * len(names)
    for number, measure in enumerate(measures):
        line, column = divmod(number, COLUMNS)
        bottom = top - ABOVE - height + 0.12 - line * (ABOVE + height + BELOW)
        box = (left + column * (width + GAP), bottom * inch, width, height * inch)
        axes = figure.add_axes(box)
        _draw_measure(axes, measure, names, scores.values())
        if measure is MEASURES[0]:
            _draw_failures(axes, scores)
        if column:
            axes.tick_params(labelleft=False)


def _draw_failures(axes: Axes, scores: Mapping[str, Scores]) -> None:
    """Fill bars of deliveries up to 100%, and write the number of failures next to them."""
    style: dict[str, Any] = {"va": "center", "fontsize": 10, "annotation_clip": False}
    axes.annotate("failed", (1.03, -0.9), **style, color=GREY)
    for place, each in enumerate(scores.values()):
        failed = len(each.rows) - int(each.delivered.sum())
        share = failed / len(each.rows)
        if failed:
            axes.barh(place, share, BAR, left=1 - share, color=PALE_WARNING, zorder=0.5)
        weight, color = ("bold", INK) if failed else ("normal", GREY)
        axes.annotate(f"{failed:,}", (1.03, place), **style, color=color, fontweight=weight)


def fitting(name: str) -> str:
    """Return an agent's name on one line, shortened at the beginning to ``MAX_LETTERS``."""
    name = printable(name)
    return name if len(name) <= MAX_LETTERS else f"\N{HORIZONTAL ELLIPSIS}{name[1 - MAX_LETTERS :]}"


def _draw_measure(
    axes: Axes, measure: Measure, names: Sequence[str], scores: Iterable[Scores]
) -> None:
    """Draw a measure as bars from 0, or as points if its axis is logarithmic and has no 0."""
    found = [measure.of(each) for each in scores]
    known = [(place, interval) for place, interval in enumerate(found) if interval is not None]
    for place in set(range(len(found))) - {place for place, _ in known}:
        axes.annotate(
            "no delivery", (0.03, place), xycoords=("axes fraction", "data"), va="center",
            fontsize=9, color=GREY,
        )  # fmt: skip
    for place, interval in known:
        if not measure.is_log:
            axes.barh(place, interval.estimate, BAR, color=BATTERY)
        else:
            axes.plot(interval.estimate, place, "o", markersize=5.5, color=BATTERY)
        if interval.is_known:
            axes.plot(interval[1:], (place, place), "|-", color=WARNING, linewidth=1.4)
    axes.set_title(measure.title, loc="left", fontsize=10, color=INK)
    axes.set_yticks(range(len(names)), names, fontsize=10.5, parse_math=False)
    axes.set_ylim(len(names) - 0.4, -0.6)
    style_chart(axes, "x")
    axes.tick_params(axis="x", labelsize=9)
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
        sizes, means = list(curve), [each.estimate for each in curve.values()]
        if name == bound:
            axes.plot(sizes, means, "--", color="0.45", linewidth=1.4, label=bound)
            continue
        color, marker = SERIES[number % len(SERIES)], MARKERS[number % len(MARKERS)]
        axes.plot(
            sizes, means, f"-{marker}", color=color, linewidth=1.8, markersize=5.5,
            label=printable(name),
        )  # fmt: skip
        known = [(size, each) for size, each in curve.items() if each.is_known]
        if known:
            low, high = zip(*(each[1:] for _, each in known), strict=True)
            axes.vlines([size for size, _ in known], low, high, color=color, linewidth=1.4)
            axes.fill_between([size for size, _ in known], low, high, color=color, alpha=0.18)
    axes.set_xlabel("robots", fontsize=9.5, color=INK)
    axes.set_ylabel(measure, fontsize=9.5, color=INK)
    axes.set_ylim(bottom=0)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if len(sizes) < 12:
        axes.set_xticks(sizes)
    style_chart(axes)
    legend = axes.legend(
        loc="upper left" if bound in curves else "lower left",
        fontsize=9,
        framealpha=1,
        edgecolor="none",
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    return figure
