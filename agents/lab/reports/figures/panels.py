"""Figures of several panels with a common legend."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any, NamedTuple

from matplotlib.axes import Axes

from agents.lab.parameters import Value, shown
from agents.lab.reports.analysis.design import Factor
from warehouse_core.render.palette import INK
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.figure import SceneFigure, make_figure

PANEL_HEIGHT, HEAD, FOOT, DPI = 3.4, 1.0, 0.42, 100
"""Heights of the parts of a figure in inches, and dots per inch."""

LEFT, RIGHT = 0.675, 0.17
"""Room beside the panels of a row, in inches."""

MAX_LEGEND_COLUMNS, LEGEND_ROW, KEY_LETTERS = 4, 0.23, 4
"""Most columns of a legend, height of a row in inches, and letters that a key takes."""

TITLE_ROW, TITLE_LETTERS = 0.24, 8.5
"""Height of a row of a title in inches, and letters in an inch of it."""

LETTERS = 10.0
"""Letters of the text of a chart in an inch."""

MAX_TICKS, MIN_LETTERS, APART = 12, 5, 1
"""Most ticks of an axis, fewest letters that a name is cut to, and letters between two names."""

Text = dict[str, Any]

TITLE_SIZE, TEXT_SIZE = 14.0, 10.5
"""Sizes in points; the smallest text of a chart is 14 CSS pixels high."""

SMALL: Text = {"fontsize": TEXT_SIZE, "color": INK}


class Sheet(NamedTuple):
    """Width of a figure in inches, and most panels side by side."""

    width: float
    panels: int


WIDE, PHONE = SHEETS = Sheet(9.0, 3), Sheet(3.4, 1)
"""Sheets for desktops and paper, and for phones 360 CSS pixels wide."""


class Panels(NamedTuple):
    """A figure, the axes of its panels, and the letters that fit along one of them."""

    figure: SceneFigure
    axes: list[Axes]
    letters: int
    legend: tuple[int, float]
    """Columns of the legend, and its distance from the top in inches."""


def make_panels(sheet: Sheet, title: str, count: int, keys: Sequence[str]) -> Panels:
    """Return a figure with ``count`` panels, a title and room for a legend with these keys."""
    columns = min(count, sheet.panels)
    rows = math.ceil(count / columns)
    lines = wrap(title, int(sheet.width * TITLE_LETTERS))
    legend_columns = _legend_columns(sheet, keys)
    above = TITLE_ROW * (len(lines) - 1)
    head = HEAD + above + LEGEND_ROW * max(math.ceil(len(keys) / legend_columns) - 1, 0)
    height = head + rows * PANEL_HEIGHT + FOOT
    figure = make_figure((sheet.width, height), DPI)
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
    figure.subplots_adjust(
        left=LEFT / sheet.width, right=1 - RIGHT / sheet.width, wspace=0.08, hspace=0.38,
        top=1 - head / height, bottom=(FOOT + 0.2) / height,
    )  # fmt: skip
    figure.suptitle(
        "\n".join(lines), x=0.1 / sheet.width, y=1 - 0.1 / height, ha="left", va="top",
        fontsize=TITLE_SIZE, color=INK,
    )  # fmt: skip
    axes = list(grid.flat)
    for each in axes[count:]:
        each.remove()
    for each in axes[:count]:
        style_chart(each, lines=None)
        each.set_facecolor("none")
        each.spines[:].set_color(INK)
        each.tick_params(labelsize=TEXT_SIZE, labelcolor=INK, color=INK)
    letters = int((sheet.width - LEFT - RIGHT) * LETTERS / columns)
    return Panels(figure, axes[:count], letters, (legend_columns, above + 0.38))


def places_of(axis: Factor) -> dict[Value, float]:
    """Return the place of each value along the axis, from 0."""
    if not axis.is_numeric:
        return {value: float(number) for number, value in enumerate(axis.values)}
    first = float(axis.values[0])
    return {value: float(value) - first for value in axis.values}


def prepare_axis(axes: Axes, axis: Factor, places: Mapping[Value, float], letters: int) -> None:
    """Set the ticks, their names and the limits of the axis of a factor."""
    step, names = fitting([shown(value) for value in places], letters)
    axes.set_xticks(list(places.values())[::step], names)
    axes.set_xlabel(axis.name, **SMALL)
    width = max(places.values())
    room = 0.06 * width if axis.is_ordered else 0.5
    axes.set_xlim(-room, width + room)


def fitting(names: Sequence[str], letters: int) -> tuple[int, list[str]]:
    """Return names that fit along an axis of some letters, and of how many each is the first.

    Their middles are left out where they would overlap, and where that is not enough, names.
    """
    room = max(letters // min(len(names), MAX_TICKS) - APART, MIN_LETTERS)
    half = (room - 1) // 2
    short = [
        name
        if len(name) <= room
        else f"{name[: room - half - 1]}\N{HORIZONTAL ELLIPSIS}{name[-half:]}"
        for name in names
    ]
    longest = max(map(len, short)) + APART
    step = math.ceil(len(names) / min(max(letters // longest, 1), MAX_TICKS))
    return step, short[::step]


def name_panel(axes: Axes, *named: tuple[Factor | None, Value | None]) -> None:
    """Write the values of some factors above a panel."""
    parts = [f"{factor.name} {shown(value)}" for factor, value in named if factor]
    axes.set_title(", ".join(parts), loc="left", **SMALL)


def draw_legend(panels: Panels, keys: Sequence[tuple[str, Any]]) -> None:
    """Draw the legend below the title, from labels and what was drawn for each."""
    labels, handles = zip(*keys, strict=True)
    figure, (columns, top) = panels.figure, panels.legend
    figure.legend(
        handles, labels, loc="upper left", ncols=columns, fontsize=TEXT_SIZE, labelcolor=INK,
        bbox_to_anchor=(0.036 / figure.get_figwidth(), 1 - top / figure.get_figheight()),
        frameon=False, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip


def _legend_columns(sheet: Sheet, labels: Sequence[str]) -> int:
    longest = max(map(len, labels), default=0) + KEY_LETTERS
    return min(max(int(sheet.width * LETTERS) // longest, 1), MAX_LEGEND_COLUMNS)
