"""The charts of a report: a measure over what differs, and what became of the episodes.

Of the factors of an experiment the one with most values goes along the axis, the next have a colour
and a panel each; over any others the episodes are pooled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from agents.experiments.setting import Value, shown
from agents.interval import Interval
from agents.reports.design import Design, Factor
from agents.reports.mode_colors import MODE_COLORS, ink_on
from agents.reports.results import Experiment, Results
from warehouse_core.display import make_figure
from warehouse_core.palette import FAINT, INK
from warehouse_core.scene_figure import SceneFigure

WIDTH, PANEL_HEIGHT, HEAD, FOOT, DPI = 9.0, 3.3, 0.85, 0.35, 100
"""In inches, and dots to an inch."""

LEGEND_COLUMNS, LEGEND_ROW = 4, 0.2

MOST_COLORS, MOST_PANELS, PANELS_A_ROW = 8, 6, 3
MOST_POINTS = 400
"""In a chart; each takes a bootstrap, and more could not be told apart."""

MOST_TICKS = 12

MOST_LETTERS = 110
"""Along the axes of all panels of a row."""

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#888888")
"""Of the lines. Source: Okabe and Ito (2008), Color universal design, without its yellow."""

MARKERS = "os^Dv*PX"

DODGE = 0.012
"""Of the width of a panel, between lines, so that no interval hides another."""

LEGIBLE = 0.08
"""Share of a bar from which a number fits into it."""

Measure = Callable[[Results], Interval | None]
Text = dict[str, Any]
SMALL: Text = {"fontsize": 8.5, "color": INK}


class Roles(NamedTuple):
    """Which factor goes where.

    Attributes:
        axis: along the axis, with the values that are drawn; ``None`` where nothing differs.
        color: ``None`` where there is one line.
        panel: ``None`` where there is one panel.
        pooled: those that are not shown.
        values: how many the factor along the axis has, drawn or not.
    """

    axis: Factor | None
    color: Factor | None
    panel: Factor | None
    pooled: tuple[Factor, ...]
    values: int = 0


def roles_of(design: Design) -> Roles:
    """Say which factor of a design goes where."""
    left = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    axis = left.pop() if left else None
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MOST_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MOST_PANELS else None
    if axis is None:
        return Roles(None, None, None, ())
    lines = math.prod(len(each.values) for each in (color, panel) if each)
    drawn = Factor(axis.name, tuple(_spread(axis.values, max(MOST_POINTS // lines, 2))))
    return Roles(drawn, color, panel, tuple(left), len(axis.values))


def _spread(values: Sequence[Value], most: int) -> list[Value]:
    """Return so many of some values at most, the first and the last among them."""
    if len(values) <= most:
        return list(values)
    return [values[number * (len(values) - 1) // (most - 1)] for number in range(most)]


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
        for where, line in _lines(experiment, design, roles).items()
    }
    if not any(point for line in lines.values() for point in line.values()):
        return None
    with mpl.rc_context({"text.parse_math": False}):
        return _draw_measure(roles, roles.axis, lines, title, unit)


def _measured(measure: Measure, results: Results) -> Interval | None:
    """Return a measure; of pooled cases, whose seeds are the same ones, without its interval."""
    found = measure(results)
    return found if found is None or len(results.case_ids) == 1 else Interval(found.estimate)


def modes_chart(experiment: Experiment, design: Design, title: str) -> SceneFigure:
    """Draw the shares of what became of the episodes, as stacked bars."""
    roles = roles_of(design)
    lines = _lines(experiment, design, roles)
    with mpl.rc_context({"text.parse_math": False}):
        return _draw_modes(roles, lines, title)


Where = tuple[Value | None, Value | None]
"""The values of the panel and of the colour."""


def _lines(
    experiment: Experiment, design: Design, roles: Roles
) -> dict[Where, dict[Value | None, Results]]:
    """Return the results of each point; one at ``None`` is the same all along the axis."""
    found: dict[Where, dict[Value | None, list[int]]] = {}
    for case_id, labels in design.labels.items():
        panel, color, along = (
            labels[role.name] if role else None for role in (roles.panel, roles.color, roles.axis)
        )
        found.setdefault((panel, color), {}).setdefault(along, []).append(case_id)
    return {
        where: {
            value: experiment.results(*line[value])
            for value in [*(roles.axis.values if roles.axis else ()), None]
            if value in line
        }
        for where, line in sorted(found.items(), key=lambda each: _place(each[0], roles))
    }


def _place(where: Where, roles: Roles) -> tuple[int, ...]:
    """Return what lines are sorted by: panels and colours in the order of their values."""
    return tuple(
        factor.values.index(value) if factor and value is not None else -1
        for factor, value in zip((roles.panel, roles.color), where, strict=True)
    )


def _draw_measure(
    roles: Roles,
    axis: Factor,
    lines: Mapping[Where, Mapping[Value | None, Interval | None]],
    title: str,
    unit: str,
) -> SceneFigure:
    panels = list(dict.fromkeys(panel for panel, _ in lines))
    colors = list(dict.fromkeys(color for _, color in lines))
    figure, axes = _panels(title, len(panels), len(colors))
    places = _places(axis)
    for (panel, color), line in lines.items():
        number = colors.index(color)
        among = sum(any(value is not None for value in each) for each in lines.values())
        shift = (number - (len(colors) - 1) / 2) * DODGE * max(places.values()) * (among > 1)
        _draw_line(axes[panels.index(panel)], axis, places, line, shift, number)
    for panel, each in zip(panels, axes, strict=True):
        _prepare_axis(each, axis, places, min(len(panels), PANELS_A_ROW))
        _name_panel(each, roles.panel, panel)
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
        _legend(figure, handles, labels, roles.color.name, colors)
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


def _draw_modes(
    roles: Roles, lines: Mapping[Where, Mapping[Value | None, Results]], title: str
) -> SceneFigure:
    occurring = {mode for line in lines.values() for results in line.values()
                 for mode in results.modes}  # fmt: skip
    figure, axes = _panels(title, len(lines), len(occurring))
    for (panel, color), line, each in zip(lines, lines.values(), axes, strict=True):
        for place, results in enumerate(line.values()):
            _draw_bar(each, place, results, len(line) * min(len(lines), PANELS_A_ROW))
        names = [shown(value) if value is not None else _everywhere(roles) for value in line]
        names = _fitting(names, min(len(lines), PANELS_A_ROW))
        step = math.ceil(len(names) / MOST_TICKS)
        each.set_xticks(range(0, len(names), step), names[::step])
        each.set_xlabel(roles.axis.name if roles.axis and [*line] != [None] else "", **SMALL)
        each.yaxis.set_major_formatter(PercentFormatter(1))
        each.set_ylim(0, 1)
        each.set_xlim(-0.6, max(len(names) - 0.4, 2.4))
        parts = [
            f"{factor.name} {shown(value)}"
            for factor, value in ((roles.panel, panel), (roles.color, color))
            if factor
        ]
        each.set_title(", ".join(parts), loc="left", **SMALL)
    handles = [Patch(color=color) for mode, color in MODE_COLORS.items() if mode in occurring]
    labels = [mode for mode in MODE_COLORS if mode in occurring]
    _legend(figure, handles, labels)
    return figure


def _draw_bar(axes: Axes, place: int, results: Results, bars: int) -> None:
    bottom = 0.0
    for mode, count in results.modes.items():
        share = count / results.episodes
        axes.bar(place, share, 0.8, bottom, color=MODE_COLORS[mode])
        if share >= LEGIBLE and bars <= 2 * MOST_TICKS:
            axes.text(
                place, bottom + share / 2, f"{share:.0%}", ha="center", va="center", fontsize=7.5,
                color=ink_on(MODE_COLORS[mode]),
            )  # fmt: skip
        bottom += share


def _everywhere(roles: Roles) -> str:
    return f"any {roles.axis.name}" if roles.axis else "all episodes"


def _panels(title: str, count: int, keys: int) -> tuple[SceneFigure, list[Axes]]:
    """Return a figure of so many panels, with its title and room for the keys of a legend."""
    columns = min(count, PANELS_A_ROW)
    rows = math.ceil(count / columns)
    head = HEAD + LEGEND_ROW * (math.ceil(keys / LEGEND_COLUMNS) - 1)
    height = head + rows * PANEL_HEIGHT + FOOT
    figure = make_figure((WIDTH, height), DPI)
    grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
    figure.subplots_adjust(
        left=0.075, right=0.98, wspace=0.08, hspace=0.38,
        top=1 - head / height, bottom=(FOOT + 0.2) / height,
    )  # fmt: skip
    figure.suptitle(title, x=0.012, y=1 - 0.1 / height, ha="left", va="top", fontsize=12, color=INK)
    axes = list(grid.flat)
    for each in axes[count:]:
        each.remove()
    for each in axes[:count]:
        each.spines[["top", "right"]].set_visible(False)
        each.tick_params(labelsize=8)
        each.set_axisbelow(True)
    return figure, axes[:count]


def _places(axis: Factor) -> dict[Value, float]:
    """Return where along the axis each value is, from 0."""
    if not axis.is_numeric:
        return {value: float(number) for number, value in enumerate(axis.values)}
    first = float(axis.values[0])
    return {value: float(value) - first for value in axis.values}


def _prepare_axis(axes: Axes, axis: Factor, places: Mapping[Value, float], columns: int) -> None:
    values = list(places)
    step = math.ceil(len(values) / MOST_TICKS)
    names = _fitting(list(map(shown, values)), columns)
    axes.set_xticks([places[each] for each in values[::step]], names[::step])
    axes.set_xlabel(axis.name, **SMALL)
    width = max(places.values())
    room = 0.06 * width if axis.is_ordered else 0.5
    axes.set_xlim(-room, width + room)


def _fitting(names: Sequence[str], columns: int) -> list[str]:
    """Return names with their middles left out, as far as they would run into each other."""
    room = max(MOST_LETTERS // (columns * min(len(names), MOST_TICKS)), 5)
    half = (room - 1) // 2
    return [
        name
        if len(name) <= room
        else f"{name[: room - half - 1]}\N{HORIZONTAL ELLIPSIS}{name[-half:]}"
        for name in names
    ]


def _name_panel(axes: Axes, factor: Factor | None, value: Value | None) -> None:
    if factor:
        axes.set_title(f"{factor.name} {shown(value)}", loc="left", **SMALL)


def _keys(axes: Iterable[Axes]) -> tuple[list[Any], list[str]]:
    """Return what a legend shows of the lines, each once."""
    found: dict[str, Any] = {}
    for each in axes:
        handles, labels = each.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            found.setdefault(label, handle)
    labels = sorted(found, key=int)
    return [found[label] for label in labels], labels


def _legend(
    figure: Figure,
    handles: Sequence[Any],
    labels: Sequence[str],
    name: str = "",
    values: Sequence[Value | None] = (),
) -> None:
    """Draw the legend below the title; labels that are numbers stand for values."""
    words = [f"{name} {shown(values[int(label)])}" for label in labels] if values else labels
    height = figure.get_figheight()
    figure.legend(
        handles, words, loc="upper left", bbox_to_anchor=(0.004, 1 - 0.33 / height),
        ncols=LEGEND_COLUMNS, fontsize=8.5, frameon=False, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip
