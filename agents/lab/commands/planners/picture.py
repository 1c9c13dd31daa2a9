"""The picture of a measure against robots, a line for each planner."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.ticker import MaxNLocator

from agents.lab.trials.interval import Interval
from warehouse_core.render.palette import INK, SERIES
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure
from warehouse_core.wording import printable

SIZE, DPI = (8.0, 4.6), 150
MARKERS = "osD^vPX*"

Curve = Mapping[int, Interval]
"""A measure for each number of robots."""


def curves_figure(
    curves: Mapping[str, Curve], title: str, measure: str, bound: str = ""
) -> SceneFigure:
    """Draw a measure of planners with its 95% intervals; the line of the bound is dashed."""
    figure = make_figure(SIZE, DPI)
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
        loc="upper left" if bound else "lower left", fontsize=9, framealpha=1, edgecolor="none"
    )
    for text in legend.get_texts():
        text.set_parse_math(False)
    return figure
