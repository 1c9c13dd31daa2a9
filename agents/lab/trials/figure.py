"""Figures that compare agents: a panel for each measure, a row for each agent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
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

WIDTH, HEIGHT, ROW_HEIGHT, DPI = 11.5, 2.5, 0.4, 110
"""Inches of the width, of the height without message and rows, and of a row; dots per inch."""

MESSAGE_LETTERS, LINE, MAX_BEST = 76, 0.26, 4
"""Letters of a line of the message, its height in inches, and most agents that it names as best."""

MAX_LETTERS, LETTER = 36, 0.0068
"""Most letters of an agent's name, whose beginning may go, and a letter's share of the width."""

CAPTION_LETTERS = 165
"""Letters in a line of the caption."""

BAR, GREY = 0.62, "0.35"
"""Height of a bar as a share of its row, and the colour of what explains."""

ROOM = 1.4
"""Factor of space on a logarithmic axis, below the lowest value and above the highest."""

PANELS = (MEASURES[0], MEASURES[2], MEASURES[1])
"""Deliveries, their steps over the fewest, and steps a delivery."""

TITLE, ABOVE, BELOW, FOOT = 0.3, 0.42, 0.5, 0.55
"""Heights in inches of a title, of the space above and below the panels of a task, and of the
caption."""

CURVES_SIZE, CURVES_DPI, MARKERS = (8.0, 4.6), 150, "osD^vPX*"
"""Inches and dots per inch of a figure of curves, and the markers of its lines."""

RIGHT, GAP = 0.965, 0.055
"""Right end of the panels, and gap between two of them, as shares of the width."""


def message(scores: Mapping[str, Scores]) -> str:
    """Return which agents deliver most and at what cost in steps, and in a line which is next."""
    delivered = {name: int(each.delivered.sum()) for name, each in scores.items()}
    total, most = len(next(iter(scores.values())).rows), max(delivered.values())
    if most == 0:
        return f"No agent delivered in {counted(total, 'episode')}"
    best = [name for name in scores if delivered[name] == most]
    names = listed(map(fitting, best)) if len(best) <= MAX_BEST else f"{len(best)} agents"
    cost = f"at {_steps(scores[name] for name in best)} a delivery"
    words = f"All {total:,} delivered by {names}, {cost}"
    if most < total:
        words = f"Most delivered by {names}: {most:,} of {total:,}, {cost}"
    others = [name for name in scores if name not in best]
    if not others:
        return words
    following = max(others, key=delivered.__getitem__)
    words += f";\n{fitting(following)} failed {counted(total - delivered[following], 'time')}"
    return f"{words}, at {_steps([scores[following]])}" if delivered[following] else words


def _steps(scores: Iterable[Scores]) -> str:
    """Return the range of the steps a delivery, in whole steps."""
    found = sorted(round(each.steps.estimate) for each in scores if each.steps)
    ends = dict.fromkeys(f"{steps:,}" for steps in (found[0], found[-1]))
    return f"{' to '.join(ends)} step{'' if found[-1] == 1 else 's'}"


def scores_figure(scores: Mapping[str, Scores], title: str, caption: str = "") -> SceneFigure:
    """Draw the agents' scores, with 95% intervals, under the message that they give."""
    names, lines = list(map(fitting, scores)), _lines(message(scores))
    head = 0.22 + LINE * len(lines)
    height = HEIGHT + head + ROW_HEIGHT * len(names)
    figure = make_figure((WIDTH, height), DPI)
    grid = figure.subplots(2, 3, sharey=True)
    figure.subplots_adjust(
        left=0.035 + LETTER * max(map(len, names)), right=0.97, top=1 - (head + 0.65) / height,
        bottom=0.95 / height, wspace=0.26, hspace=0.42,
    )  # fmt: skip
    _write_head(figure, height - 0.12, lines, title, height - head)
    _write_caption(figure, caption)
    for axes, measure in zip(grid.flat, MEASURES, strict=True):
        _draw_measure(axes, measure, names, scores.values())
    _draw_failures(grid.flat[0], scores)
    return figure


def sizes_figure(groups: Mapping[str, Mapping[str, Scores]], caption: str = "") -> SceneFigure:
    """Draw the scores of the same agents in several tasks, such as layouts of several sizes."""
    said = [_lines(message(scores)) for scores in groups.values()]
    agents = len(next(iter(groups.values())))
    heights = [LINE * len(lines) + TITLE + ABOVE + ROW_HEIGHT * agents + BELOW for lines in said]
    figure = make_figure((WIDTH, sum(heights) + FOOT), DPI)
    top = sum(heights) + FOOT - 0.12
    for (title, scores), lines, height in zip(groups.items(), said, heights, strict=True):
        below = top - LINE * len(lines)
        _write_head(figure, top, lines, title, below)
        _draw_panels(figure, below, scores)
        top -= height
    _write_caption(figure, caption)
    return figure


def _draw_panels(figure: SceneFigure, title: float, scores: Mapping[str, Scores]) -> None:
    """Draw a row of panels below a title, whose top is ``title`` inches from the bottom."""
    inch, names = 1 / figure.get_figheight(), list(map(fitting, scores))
    left = 0.035 + LETTER * max(map(len, names))
    width = (RIGHT - left - GAP * (len(PANELS) - 1)) / len(PANELS)
    height = ROW_HEIGHT * len(names)
    bottom = title - TITLE - ABOVE - height + 0.12
    for number, measure in enumerate(PANELS):
        box = (left + number * (width + GAP), bottom * inch, width, height * inch)
        axes = figure.add_axes(box)
        _draw_measure(axes, measure, names, scores.values())
        if measure is MEASURES[0]:
            _draw_failures(axes, scores)
        if number:
            axes.tick_params(labelleft=False)


def _lines(words: str) -> list[str]:
    return [part for line in words.split("\n") for part in wrap(line, MESSAGE_LETTERS)]


def _write_head(
    figure: SceneFigure, top: float, lines: Sequence[str], title: str, below: float
) -> None:
    """Write a message below ``top`` and a title below ``below``, in inches from the bottom."""
    inch, said = 1 / figure.get_figheight(), "\n".join(lines)
    style: dict[str, Any] = {"ha": "left", "va": "top", "parse_math": False}
    figure.text(0.012, top * inch, said, fontsize=15, fontweight="bold", color=INK, **style)
    figure.text(0.012, below * inch, title, fontsize=10, color=GREY, **style)


def _write_caption(figure: SceneFigure, caption: str) -> None:
    words, y = fill(caption, CAPTION_LETTERS), 0.1 / figure.get_figheight()
    figure.text(0.012, y, words, fontsize=9, color=GREY, parse_math=False)


def _draw_failures(axes: Axes, scores: Mapping[str, Scores]) -> None:
    """Fill bars of deliveries up to 100%, and write the number of failures beside them."""
    beside: dict[str, Any] = {"va": "center", "fontsize": 10, "annotation_clip": False}
    axes.annotate("failed", (1.03, -0.9), **beside, color=GREY)
    for place, each in enumerate(scores.values()):
        failed = len(each.rows) - int(each.delivered.sum())
        share = failed / len(each.rows)
        if failed:
            axes.barh(place, share, BAR, left=1 - share, color=PALE_WARNING, zorder=0.5)
        weight, color = ("bold", INK) if failed else ("normal", GREY)
        axes.annotate(f"{failed:,}", (1.03, place), **beside, color=color, fontweight=weight)


def fitting(name: str) -> str:
    """Return the name of an agent as one line of at most ``MAX_LETTERS``, its end if it is long."""
    name = printable(name)
    return name if len(name) <= MAX_LETTERS else f"\N{HORIZONTAL ELLIPSIS}{name[1 - MAX_LETTERS :]}"


def _draw_measure(
    axes: Axes, measure: Measure, names: Sequence[str], scores: Iterable[Scores]
) -> None:
    """Draw bars from 0, or points on a logarithmic axis, which has no 0."""
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
    """Draw a measure for each number of robots with its 95% intervals; the bound is dashed."""
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
