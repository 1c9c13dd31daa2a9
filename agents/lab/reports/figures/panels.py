"""Figures of several panels with a common legend."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from agents.lab.parameters import Value, shown
from agents.lab.reports.analysis.design import Factor
from warehouse_core.render.palette import INK
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure

WIDTH, PANEL_HEIGHT, HEAD, FOOT, DPI = 9.0, 3.4, 1.0, 0.42, 100
"""Width of a figure and heights of its parts in inches, and dots per inch."""

MAX_LEGEND_COLUMNS, LEGEND_ROW, LEGEND_LETTERS = 4, 0.23, 92
"""Most columns of a legend, height of a row in inches, and its letters; a key takes four more."""

MAX_TICKS = 12

PANELS_A_ROW = 3

MAX_LETTERS = 80
"""Most letters along the axes of all panels of a row."""

Text = dict[str, Any]

TITLE_SIZE, TEXT_SIZE = 14.0, 10.5
"""Sizes in points; the smallest text of a chart is 14 CSS pixels high."""

SMALL: Text = {"fontsize": TEXT_SIZE, "color": INK}


def make_panels(title: str, count: int, keys: Sequence[str]) -> tuple[SceneFigure, list[Axes]]:
    """Return a figure with ``count`` panels, a title and room for a legend with these keys."""
    columns = min(count, PANELS_A_ROW)
    rows = math.ceil(count / columns)
    head = HEAD + LEGEND_ROW * max(math.ceil(len(keys) / _legend_columns(keys)) - 1, 0)
    height = head + rows * PANEL_HEIGHT + FOOT
    figure = make_figure((WIDTH, height), DPI)
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
    figure.subplots_adjust(
        left=0.075, right=0.98, wspace=0.08, hspace=0.38,
        top=1 - head / height, bottom=(FOOT + 0.2) / height,
    )  # fmt: skip
    figure.suptitle(
        title, x=0.012, y=1 - 0.1 / height, ha="left", va="top", fontsize=TITLE_SIZE, color=INK
    )
    axes = list(grid.flat)
    for each in axes[count:]:
        each.remove()
    for each in axes[:count]:
        style_chart(each, lines=None)
        each.set_facecolor("none")
        each.spines[:].set_color(INK)
        each.tick_params(labelsize=TEXT_SIZE, labelcolor=INK, color=INK)
    return figure, axes[:count]


def places_of(axis: Factor) -> dict[Value, float]:
    """Return the place of each value along the axis, from 0."""
    if not axis.is_numeric:
        return {value: float(number) for number, value in enumerate(axis.values)}
    first = float(axis.values[0])
    return {value: float(value) - first for value in axis.values}


def prepare_axis(axes: Axes, axis: Factor, places: Mapping[Value, float], columns: int) -> None:
    """Set the ticks, their names and the limits of the axis of a factor."""
    values = list(places)
    step = math.ceil(len(values) / MAX_TICKS)
    names = fitting(list(map(shown, values)), columns)
    axes.set_xticks([places[each] for each in values[::step]], names[::step])
    axes.set_xlabel(axis.name, **SMALL)
    width = max(places.values())
    room = 0.06 * width if axis.is_ordered else 0.5
    axes.set_xlim(-room, width + room)


def fitting(names: Sequence[str], columns: int) -> list[str]:
    """Return names with their middles left out where they would overlap."""
    room = max(MAX_LETTERS // (columns * min(len(names), MAX_TICKS)), 5)
    half = (room - 1) // 2
    return [
        name
        if len(name) <= room
        else f"{name[: room - half - 1]}\N{HORIZONTAL ELLIPSIS}{name[-half:]}"
        for name in names
    ]


def name_panel(axes: Axes, *named: tuple[Factor | None, Value | None]) -> None:
    """Write the values of some factors above a panel."""
    parts = [f"{factor.name} {shown(value)}" for factor, value in named if factor]
    axes.set_title(", ".join(parts), loc="left", **SMALL)


def draw_legend(figure: Figure, keys: Sequence[tuple[str, Any]]) -> None:
    """Draw the legend below the title, from labels and what was drawn for each."""
    labels, handles = zip(*keys, strict=True)
    height = figure.get_figheight()
    figure.legend(
        handles, labels, loc="upper left", bbox_to_anchor=(0.004, 1 - 0.38 / height),
        ncols=_legend_columns(labels), fontsize=TEXT_SIZE, labelcolor=INK, frameon=False,
        columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip


def _legend_columns(labels: Sequence[str]) -> int:
    longest = max(map(len, labels), default=0) + 4
    return min(max(LEGEND_LETTERS // longest, 1), MAX_LEGEND_COLUMNS)
