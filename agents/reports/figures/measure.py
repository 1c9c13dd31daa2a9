"""The charts of a report: a measure over what differs, and what became of the episodes.

Of the factors of an experiment the one with most values goes along the axis, the next have a colour
and a panel each; over any others the episodes are pooled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.ticker import PercentFormatter

from agents.evaluation.interval import Interval
from agents.experiments.parameters import Value
from agents.reports.analysis.design import Design, Factor
from agents.reports.analysis.results import Experiment, Results
from agents.reports.figures.panels import (
    PANELS_A_ROW,
    SMALL,
    Text,
    draw_legend,
    make_panels,
    name_panel,
    places_of,
    prepare_axis,
)
from agents.reports.figures.roles import Roles, Where, lines_of, roles_of
from warehouse_core.records.episode import BATTERY_DEPLETED, DELIVERED, OUT_OF_TIME, UNFINISHED
from warehouse_core.records.failure_modes import OSCILLATION, STALLED, UNREACHABLE, WANDERING
from warehouse_core.render.palette import FAINT
from warehouse_core.viz.figure import SceneFigure

MODE_COLORS = {
    DELIVERED: "#2a9d5c",
    UNREACHABLE: "#6b6b70",
    STALLED: "#8c4fa3",
    OSCILLATION: "#d1495b",
    WANDERING: "#edae49",
    BATTERY_DEPLETED: "#2e6fa7",
    OUT_OF_TIME: "#8ab6d6",
    UNFINISHED: "#c9c9ce",
}

LUMINANCE = (0.299, 0.587, 0.114)
"""Weights of R, G and B. Source: ITU-R BT.601."""


def ink_on(color: str) -> str:
    """Return black or white, whichever can be read on a colour."""
    light = sum(weight * part for weight, part in zip(LUMINANCE, to_rgb(color), strict=True))
    return "black" if light > 0.55 else "white"


COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#888888")
"""Of the lines. Source: Okabe and Ito (2008), Color universal design, without its yellow."""

MARKERS = "os^Dv*PX"

DODGE = 0.012
"""Of the width of a panel, between lines, so that no interval hides another."""

Measure = Callable[[Results], Interval | None]


def measure_chart(
    experiment: Experiment, design: Design, title: str, unit: str, measure: Measure
) -> SceneFigure | None:
    """Draw a measure with its intervals.

    Args:
        experiment: the results.
        design: of the cases that are drawn.
        title: of the picture.
        unit: of the measure; ``"%"`` for shares.
        measure: returns ``None`` where there is nothing to measure.

    Returns:
        ``None`` where nothing differs or there is nothing to measure.
    """
    roles = roles_of(design)
    if roles.axis is None:
        return None
    lines = {
        where: {value: _measured(measure, results) for value, results in line.items()}
        for where, line in lines_of(experiment, design, roles).items()
    }
    if not any(point for line in lines.values() for point in line.values()):
        return None
    with mpl.rc_context({"text.parse_math": False}):
        return _draw_measure(roles, roles.axis, lines, title, unit)


def _measured(measure: Measure, results: Results) -> Interval | None:
    """Return a measure; of pooled cases, whose seeds are the same ones, without its interval."""
    found = measure(results)
    return found if found is None or len(results.case_ids) == 1 else Interval(found.estimate)


def _draw_measure(
    roles: Roles,
    axis: Factor,
    lines: Mapping[Where, Mapping[Value | None, Interval | None]],
    title: str,
    unit: str,
) -> SceneFigure:
    panels = list(dict.fromkeys(panel for panel, _ in lines))
    colors = list(dict.fromkeys(color for _, color in lines))
    figure, axes = make_panels(title, len(panels), len(colors))
    places = places_of(axis)
    for (panel, color), line in lines.items():
        number = colors.index(color)
        among = sum(any(value is not None for value in each) for each in lines.values())
        shift = (number - (len(colors) - 1) / 2) * DODGE * max(places.values()) * (among > 1)
        _draw_line(axes[panels.index(panel)], axis, places, line, shift, number)
    for panel, each in zip(panels, axes, strict=True):
        prepare_axis(each, axis, places, min(len(panels), PANELS_A_ROW))
        name_panel(each, roles.panel, panel)
        each.grid(axis="y", color=FAINT, linewidth=0.5)
        if unit == "%":
            each.yaxis.set_major_formatter(PercentFormatter(1))
            each.set_ylim(-0.02, 1.02)
        else:
            each.set_ylim(bottom=0)
    if unit != "%":
        axes[0].set_ylabel(unit, **SMALL)
    if roles.color:
        handles, labels = _keys(axes)
        draw_legend(figure, handles, labels, roles.color.name, colors)
    return figure


def _draw_line(
    axes: Axes,
    axis: Factor,
    places: Mapping[Value, float],
    line: Mapping[Value | None, Interval | None],
    shift: float,
    number: int,
) -> None:
    look: Text = {"color": COLORS[number], "linewidth": 1.6}
    points = [(places[value] + shift, point) for value, point in line.items()
              if value is not None and point]  # fmt: skip
    if points:
        middles = [point.estimate for _, point in points]
        reach = [
            [point.estimate - point.low for _, point in points],
            [point.high - point.estimate for _, point in points],
        ]
        axes.errorbar(
            [place for place, _ in points], middles, reach, fmt=MARKERS[number], capsize=3,
            markersize=5, linestyle="-" if axis.is_ordered else "none", label=str(number), **look,
        )  # fmt: skip
    everywhere = line.get(None)
    if everywhere:
        axes.axhline(everywhere.estimate, linestyle=(0, (5, 2)), label=str(number), **look)
        axes.axhspan(everywhere.low, everywhere.high, color=COLORS[number], alpha=0.15, lw=0)


def _keys(axes: Iterable[Axes]) -> tuple[list[Any], list[str]]:
    """Return what a legend shows of the lines, each once."""
    found: dict[str, Any] = {}
    for each in axes:
        handles, labels = each.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            found.setdefault(label, handle)
    labels = sorted(found, key=int)
    return [found[label] for label in labels], labels
