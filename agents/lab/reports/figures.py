"""The figures of a report and their captions: charts of measures and outcomes, and heat maps.

The factor with the most values is shown along the axis, and the next two as colours and panels.
Episodes are pooled over all other factors. ``H`` and ``W`` are the height and the width of a layout
in cells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from itertools import product
from math import ceil
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from agents.errors import StoreError
from agents.lab.experiments.case import TILES
from agents.lab.parameters import Value, shown
from agents.lab.reports.results import LONE, Design, Experiment, Factor, ReportedMeasure, Results
from agents.lab.trials.figure import (
    TEXT_SIZE,
    WIDTH,
    draw_legend,
    draw_line,
    make_panels,
    scale_axis,
)
from agents.lab.trials.interval import CONFIDENCE, Interval
from agents.lab.trials.rows import MODES_OF
from warehouse_core.records import failure_modes as modes
from warehouse_core.records.episode import BATTERY_DEPLETED, DELIVERED, OUT_OF_TIME, UNFINISHED
from warehouse_core.render.palette import PALETTE, PAPER, SERIES
from warehouse_core.viz.axes.heat_map import CellCounts, heat_map
from warehouse_core.viz.figure import SceneFigure, save_svg
from warehouse_core.wording import counted, listed

MAX_MAPS, MAX_CELLS = 4, 300_000
"""Maximum number of heat maps, which show the layouts with the most episodes, and maximum number of
cells in each; cells of larger layouts would be invisible."""

STATIONS = {
    "drawn": "Pickup and dropoff are random in each episode",
    "kept": "Pickup (P) and dropoff (D) are the stations of the layout in every episode",
}


class Picture(NamedTuple):
    """A figure as SVG, its caption, and the stem of its file as its name."""

    name: str
    caption: str
    svg: bytes


def pictures(experiment: Experiment) -> Iterator[Picture]:
    """Yield the figures that are not empty."""
    kind, chart = experiment.kind, ReportChart(experiment, experiment.design)
    physical = {n: case for n, case in experiment.cases.items() if case["backend"] != "grid"}
    bodies = ReportChart(experiment, Design(physical))
    backends = sorted({shown(case["backend"]) for case in physical.values()})
    for measure in kind.measures:
        drawn, title = chart, measure.title
        if measure.is_physical:
            drawn, title = bodies, f"{title}, backend {listed(backends)}" if backends else title
        if figure := measure_figure(drawn, title, measure):
            words = f"{title}: {measure.what}, with {CONFIDENCE:.0%} intervals{drawn.left_out}."
            yield Picture(measure.name, words, svg_of(figure))
    words = f"{kind.modes_title}, as shares{chart.left_out}."
    yield Picture(kind.modes, words, svg_of(modes_figure(chart, kind.modes_title)))
    if kind is LONE:
        yield from _maps(experiment)


def svg_of(figure: Figure) -> bytes:
    """Return a figure as SVG."""
    file = BytesIO()
    save_svg(figure, file)
    return file.getvalue()


def _maps(experiment: Experiment) -> Iterator[Picture]:
    """Yield a heat map for each layout and choice of stations, most episodes first."""
    layouts: dict[tuple[tuple[str, ...], str], list[int]] = {}
    for case_id, case in experiment.cases.items():
        rows = tuple(case.get(TILES, ()))
        if 0 < len(rows) * len(rows[0] if rows else "") <= MAX_CELLS:
            layouts.setdefault((rows, case["stations"]), []).append(case_id)
    most_first = sorted(layouts.items(), key=lambda each: -experiment.results(*each[1]).episodes)
    for number, ((rows, stations), ids) in enumerate(most_first[:MAX_MAPS], start=1):
        episodes, name = experiment.results(*ids).episodes, experiment.cases[ids[0]]["layout"]
        stuck = {
            f"{mode}: {cells.sum():,} ({cells.sum() / episodes:.1%})": cells
            for mode, cells in stuck_cells(experiment, rows, ids).items()
        }
        if not stuck:
            continue
        caption = (
            f"Where robots got stuck on layout {shown(name)}: number of episodes with each failure "
            f"mode, out of {counted(episodes, 'episode')}, by the cell where the robot got stuck "
            f"or the episode ended. {STATIONS[stations]}."
        )
        figure = heat_map(rows, stuck, width=WIDTH, with_stations=stations == "kept")
        yield Picture(f"stuck-{number}", caption, svg_of(figure))


def stuck_cells(
    experiment: Experiment, rows: Sequence[str], case_ids: Sequence[int]
) -> dict[str, CellCounts]:
    """Count the episodes that got stuck or ended in each cell, ``[H, W]``, for each failure mode.

    Modes are in the order of ``MODES``.

    Raises:
        StoreError: an episode got stuck outside the layout.
    """
    columns = experiment.results(*case_ids).columns
    size = len(rows), len(rows[0])
    if columns["row"].max() >= size[0] or columns["col"].max() >= size[1]:
        raise StoreError(f"{experiment.path}: an episode ended outside the layout")
    stuck: dict[str, CellCounts] = {}
    for mode in experiment.results(*case_ids).modes:
        if mode != DELIVERED:
            is_it, stuck[mode] = columns["mode"] == mode, np.zeros(size, dtype=np.int64)
            np.add.at(stuck[mode], (columns["row"][is_it], columns["col"][is_it]), 1)
    return stuck


MAX_COLORS, MAX_PANELS, MAX_VALUES = 8, 6, 50
"""Maximum numbers of colours, of panels, and of values along the axis, which are evenly chosen."""


class ReportChart:
    """The results of a design as points of a chart, with a role for each factor.

    Attributes:
        axis: Factor along the axis.
        color: Factor that is shown by colours.
        panel: Factor with a panel for each value.
        left_out: End of a caption, which names the factors that the chart leaves out.
        lines: Results by the value along the axis, for each value of the panel and the colour. The
            axis factor does not apply to results at ``None``, which are the same along the axis.
    """

    def __init__(self, experiment: Experiment, design: Design) -> None:
        self.kind, self.left_out = experiment.kind, ""
        self.axis, self.color, self.panel, pooled = roles_of(design)
        if pooled:
            self.left_out = f"; pooled over {listed([factor.name for factor in pooled])}"
        if self.axis and (step := ceil(len(self.axis.values) / MAX_VALUES)) > 1:
            self.left_out += f"; only one in {step} values of {self.axis.name} is drawn"
            self.axis = self.axis._replace(values=self.axis.values[::step])
        roles = self.panel, self.color, self.axis
        found: dict[tuple[Value | None, ...], list[int]] = {}
        for case_id, labels in design.labels.items():
            key = tuple(labels[role.name] if role else None for role in roles)
            found.setdefault(key, []).append(case_id)
        panels, colors, values = ((None, *(role.values if role else ())) for role in roles)
        self.lines = {
            (panel, color): line
            for panel, color in product(panels, colors)
            if (line := {
                value: experiment.results(*found[panel, color, value])
                for value in (*values[1:], None)
                if (panel, color, value) in found
            })
        }  # fmt: skip


def roles_of(design: Design) -> tuple[Factor | None, Factor | None, Factor | None, list[Factor]]:
    """Return the factors for axis, colours and panels, and those over which episodes are pooled."""
    if not design.factors:
        return None, None, None, []
    *left, axis = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MAX_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MAX_PANELS else None
    return axis, color, panel, left


DODGE = 0.012
"""Horizontal distance between lines as a share of the width."""


def _named(*parts: tuple[Factor | None, Value | None]) -> str:
    """Return the values of some factors as the title of a panel."""
    return ", ".join(f"{factor.name} {shown(value)}" for factor, value in parts if factor)


@mpl.rc_context({"text.parse_math": False})
def measure_figure(chart: ReportChart, title: str, measure: ReportedMeasure) -> SceneFigure | None:
    """Draw a measure with its intervals, or return ``None`` if there is nothing to compare."""
    axis = chart.axis
    lines = {
        where: {value: measured(measure, results) for value, results in line.items()}
        for where, line in chart.lines.items()
    }
    if axis is None or not any(point for line in lines.values() for point in line.values()):
        return None
    panels, colors = (list(dict.fromkeys(column)) for column in zip(*lines, strict=True))
    labels = [_named((chart.color, value)) for value in colors]
    numbers = axis.values if axis.is_numeric else range(len(axis.values))
    places = {value: float(each) for value, each in zip(axis.values, numbers, strict=True)}
    figure, axes = make_panels(
        title,
        [_named((chart.panel, value)) for value in panels],
        labels if chart.color else [],
        axis.name,
        {shown(value): place for value, place in places.items()},
    )
    first, last = min(places.values()), max(places.values())
    keys: dict[str, Any] = {}
    for (value, shade), line in lines.items():
        number = colors.index(shade)
        shift = (number - (len(colors) - 1) / 2) * DODGE * (last - first)
        points = {places[at] + shift: each for at, each in line.items() if at is not None and each}
        panel, label = axes[panels.index(value)], labels[number]
        if points:
            drawn = draw_line(panel, points, number, "-" if axis.is_ordered else "")
            keys.setdefault(label, drawn)
        if everywhere := line.get(None):
            look: dict[str, Any] = {"color": SERIES[number], "linewidth": 1.6}
            dashed = panel.axhline(everywhere.estimate, linestyle=(0, (5, 2)), **look)
            panel.axhspan(everywhere.low, everywhere.high, color=SERIES[number], alpha=0.15, lw=0)
            keys.setdefault(label, dashed)
    room = 0.06 * (last - first) if axis.is_ordered else 0.5
    for each in axes:
        each.set_xlim(first - room, last + room)
        scale_axis(each, measure.unit)
    if chart.color:
        draw_legend(figure, title, keys)
    return figure


def measured(measure: ReportedMeasure, results: Results) -> Interval | None:
    """Return a measure, without its interval if cases are pooled, because they share seeds."""
    interval = results.interval(measure)
    if interval is None or len(results.case_ids) == 1:
        return interval
    return Interval(interval.estimate)


COLORS = {
    "delivered": (DELIVERED, modes.SERVED),
    "unreachable": (modes.UNREACHABLE,),
    "stalled": (modes.STALLED, modes.TOO_MANY_ORDERS, modes.OVERTAKEN),
    "ineffective": (modes.INEFFECTIVE, modes.PEOPLE),
    "oscillation": (modes.OSCILLATION, modes.DEADLOCK),
    "wandering": (modes.WANDERING, modes.CONGESTED),
    "out-of-battery": (
        BATTERY_DEPLETED, modes.NO_CHARGER, modes.OVERSUBSCRIBED, modes.FLAT_IN_THE_WAY,
        modes.STRANDED,
    ),
    "out-of-time": (OUT_OF_TIME, modes.LATE),
    "unfinished": (UNFINISHED, modes.IDLE),
}  # fmt: skip
"""Outcomes by their colours. Outcomes of lone robots and of fleets are never in the same chart."""

MODE_COLORS = {mode: PALETTE["both"][name] for name, group in COLORS.items() for mode in group}

FIRST_MODES = DELIVERED, modes.UNREACHABLE, modes.SERVED
"""Outcomes at the beginning of a legend; the others follow in the order of their table."""

MIN_LEGIBLE, MAX_NUMBERED = 0.08, 7
"""Minimum share of a segment with a number, and maximum number of bars in a panel with numbers."""


@mpl.rc_context({"text.parse_math": False})
def modes_figure(chart: ReportChart, title: str) -> SceneFigure:
    """Draw the shares of the outcomes as stacked bars."""
    axis = chart.axis
    everywhere = f"any {axis.name}" if axis else "all episodes"
    found = {value for line in chart.lines.values() for value in line}
    values = [value for value in (*(axis.values if axis else ()), None) if value in found]
    names = [everywhere if value is None else shown(value) for value in values]
    occurring = {m for line in chart.lines.values() for each in line.values() for m in each.modes}
    in_order = dict.fromkeys([*FIRST_MODES, *MODES_OF[chart.kind.row]])
    keys = {mode: Patch(color=MODE_COLORS[mode]) for mode in in_order if mode in occurring}
    figure, axes = make_panels(
        title,
        [_named((chart.panel, value), (chart.color, shade)) for value, shade in chart.lines],
        list(keys),
        axis.name if axis else "",
        {name: float(place) for place, name in enumerate(names)},
    )
    for line, each in zip(chart.lines.values(), axes, strict=True):
        for along, results in line.items():
            _draw_bar(each, values.index(along), results, is_numbered=len(values) <= MAX_NUMBERED)
        each.yaxis.set_major_formatter(PercentFormatter(1))
        each.set_ylim(0, 1)
        each.set_xlim(-0.6, max(len(values) - 0.4, 2.4))
    draw_legend(figure, title, keys)
    return figure


def _draw_bar(axes: Axes, place: int, results: Results, *, is_numbered: bool) -> None:
    bottom = 0.0
    for mode, count in results.modes.items():
        share = count / results.episodes
        axes.bar(place, share, 0.8, bottom, color=MODE_COLORS[mode], edgecolor=PAPER)
        if share >= MIN_LEGIBLE and is_numbered:
            axes.text(
                place, bottom + share / 2, f"{share:.0%}", ha="center", va="center",
                fontsize=TEXT_SIZE, color=ink_on(MODE_COLORS[mode]),
            )  # fmt: skip
        bottom += share


def ink_on(color: str) -> str:
    """Return the colour for text on a colour: black or near-white, whichever is legible."""
    luminance = np.dot((0.2126, 0.7152, 0.0722), np.power(to_rgb(color), 2.2))  # as in WCAG 2.2
    return "black" if luminance > 0.17 else "whitesmoke"
