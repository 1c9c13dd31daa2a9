"""The charts of a measure over what differs.

The factor with most values is along the axis, the next two are colours and panels; over any others
the episodes are pooled.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

from agents.lab.parameters import Value, shown
from agents.lab.reports.analysis.design import Design, Factor
from agents.lab.reports.analysis.results import Experiment, ReportedMeasure, Results
from agents.lab.reports.figures.panels import (
    SMALL,
    WIDE,
    Sheet,
    Text,
    draw_legend,
    make_panels,
    name_panel,
    places_of,
    prepare_axis,
)
from agents.lab.reports.figures.roles import lines_of, roles_of
from agents.lab.trials.interval import Interval
from warehouse_core.render.palette import FAINT, SERIES
from warehouse_core.viz.figure import SceneFigure

MARKERS = "os^Dv*PX"

DODGE = 0.012
"""Distance between lines as a share of the width, so that no interval hides another."""


@mpl.rc_context({"text.parse_math": False})
def measure_chart(
    experiment: Experiment,
    design: Design,
    title: str,
    measure: ReportedMeasure,
    sheet: Sheet = WIDE,
) -> SceneFigure | None:
    """Draw a measure with its intervals, unless nothing differs or there is nothing to measure."""
    roles = roles_of(design)
    if roles.axis is None:
        return None
    lines = {
        where: {value: measured(measure, results) for value, results in line.items()}
        for where, line in lines_of(experiment, design, roles).items()
    }
    if not any(point for line in lines.values() for point in line.values()):
        return None
    values = list(dict.fromkeys(panel for panel, _ in lines))
    colors = list(dict.fromkeys(color for _, color in lines))
    name = roles.color.name if roles.color else ""
    labels = {color: f"{name} {shown(color)}" for color in colors if roles.color}
    panels = make_panels(sheet, title, len(values), list(labels.values()))
    places = places_of(roles.axis)
    placed = sum(any(value is not None for value in line) for line in lines.values())
    width = max(places.values()) if placed > 1 else 0
    keys: dict[Value | None, Any] = {}
    for (panel, color), line in lines.items():
        number = colors.index(color)
        shift = (number - (len(colors) - 1) / 2) * DODGE * width
        key = _draw_line(panels.axes[values.index(panel)], roles.axis, places, line, shift, number)
        if key:
            keys.setdefault(color, key)
    for panel, each in zip(values, panels.axes, strict=True):
        prepare_axis(each, roles.axis, places, panels.letters)
        name_panel(each, (roles.panel, panel))
        each.grid(axis="y", color=FAINT, linewidth=0.5)
        if measure.unit == "%":
            each.yaxis.set_major_formatter(PercentFormatter(1))
            each.set_ylim(-0.02, 1.02)
        else:
            each.set_ylim(bottom=0)
    if measure.unit != "%":
        panels.axes[0].set_ylabel(measure.unit, **SMALL)
    if roles.color:
        draw_legend(panels, [(labels[each], keys[each]) for each in colors if each in keys])
    return panels.figure


def measured(measure: ReportedMeasure, results: Results) -> Interval | None:
    """Return a measure, without its interval if cases are pooled: they share their seeds."""
    interval = results.interval(measure)
    if interval is None or len(results.case_ids) == 1:
        return interval
    return Interval(interval.estimate)


def _draw_line(
    axes: Axes,
    axis: Factor,
    places: Mapping[Value, float],
    line: Mapping[Value | None, Interval | None],
    shift: float,
    number: int,
) -> Any:
    """Draw the results of one colour and return what a legend shows of them."""
    key: Any = None
    look: Text = {"color": SERIES[number], "linewidth": 2.0}
    points = [(places[value] + shift, point) for value, point in line.items()
              if value is not None and point]  # fmt: skip
    if points:
        middles = [point.estimate for _, point in points]
        reach = [
            [point.estimate - point.low for _, point in points],
            [point.high - point.estimate for _, point in points],
        ]
        key = axes.errorbar(
            [place for place, _ in points], middles, reach, fmt=MARKERS[number], capsize=3,
            markersize=6.5, linestyle="-" if axis.is_ordered else "none", **look,
        )  # fmt: skip
    everywhere = line.get(None)
    if everywhere:
        key = axes.axhline(everywhere.estimate, linestyle=(0, (5, 2)), **look)
        axes.axhspan(everywhere.low, everywhere.high, color=SERIES[number], alpha=0.15, lw=0)
    return key
