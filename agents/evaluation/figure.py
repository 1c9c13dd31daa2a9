"""A figure that compares agents: a panel for each measure, a bar for each agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, PercentFormatter

from agents.evaluation.interval import Interval
from agents.evaluation.scores import MEASURES, Scores
from warehouse_core.render.palette import BATTERY, INK, WARNING
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure

SIZE, DPI = (10.0, 5.2), 120


def scores_figure(scores: Mapping[str, Scores], title: str) -> SceneFigure:
    """Draw the agents' scores, with 95% intervals."""
    figure = make_figure(SIZE, DPI)
    grid = figure.subplots(2, 3, sharey=True)
    figure.subplots_adjust(left=0.16, right=0.97, top=0.85, bottom=0.08, wspace=0.12, hspace=0.42)
    figure.suptitle(title, x=0.012, y=0.97, ha="left", fontsize=12, color=INK)
    for axes, measure in zip(grid.flat, MEASURES, strict=True):
        found = [measure.of(each) for each in scores.values()]
        _draw(axes, measure.title, list(scores), found)
    return figure


def _draw(axes: Axes, name: str, agents: Sequence[str], found: Sequence[Interval | None]) -> None:
    for place, interval in enumerate(found):
        if interval is None:
            continue
        axes.barh(place, interval.estimate, 0.62, color=BATTERY)
        if interval.is_known:
            ends = [interval.estimate - interval.low], [interval.high - interval.estimate]
            axes.errorbar(
                interval.estimate, place, xerr=ends, ecolor=WARNING, capsize=3, fmt="none"
            )
    axes.set_title(name, loc="left", fontsize=9.5, color=INK)
    axes.set_yticks(range(len(agents)), agents, fontsize=9)
    axes.set_ylim(len(agents) - 0.4, -0.6)
    axes.set_xlim(left=0)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5))
    if name == MEASURES[0].title:
        axes.xaxis.set_major_formatter(PercentFormatter(1))
        axes.set_xlim(0, 1)
    style_chart(axes, "x")
