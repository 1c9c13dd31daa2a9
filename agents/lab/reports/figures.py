"""The figures of a report: charts of measures and of outcomes, and heat maps, with captions.

The factor with most values is along the axis, the next two are colours and panels; over any others
the episodes are pooled. ``H`` is the height of a layout and ``W`` its width, in cells.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import product
from textwrap import wrap
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from agents.errors import StoreError
from agents.lab.experiments.case import TILES, cells_of
from agents.lab.experiments.store import Store
from agents.lab.parameters import Value, shown
from agents.lab.reports.design import Design, Factor, make_design
from agents.lab.reports.results import LONE, SUCCESS, Experiment, ReportedMeasure, Results
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES, Interval
from warehouse_core.records import failure_modes as modes
from warehouse_core.records.episode import BATTERY_DEPLETED, DELIVERED, OUT_OF_TIME, UNFINISHED
from warehouse_core.render.palette import FAINT, INK, PALETTE, PAPER, SERIES
from warehouse_core.viz.axes import style_chart
from warehouse_core.viz.axes.heat_map import DARK_HEAT, HEAT, CellCounts, heat_map
from warehouse_core.viz.figure import SceneFigure, make_figure, save_svg
from warehouse_core.wording import counted, listed

MAX_MAPS = 4
"""Heat maps at most; the layouts with most episodes have them."""

MAX_CELLS = 300_000
"""Cells of a layout that has a heat map or a replay; in a larger one no cell could be seen."""

STATIONS = {
    "drawn": "Pickup and dropoff are random in each episode",
    "kept": "Pickup (P) and dropoff (D) are those of the layout in every episode",
}


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as SVG, for wide screens and for phones, with its caption.

    Its name is the stem of its file.
    """

    name: str
    caption: str
    svg: bytes
    phone: bytes


def pictures(experiment: Experiment) -> Iterator[Picture]:
    """Yield the figures that are not empty."""
    kind, chart = experiment.kind, DesignPoints(experiment, experiment.design)
    physical = {n: case for n, case in experiment.cases.items() if case["backend"] != "grid"}
    bodies = DesignPoints(experiment, make_design(physical))
    backends = sorted({shown(case["backend"]) for case in physical.values()})
    on = f", backend {listed(backends)}" if backends else ""
    for measure in kind.measures:
        if measure.is_physical:
            yield from _measure_picture(bodies, measure, measure.title + on)
        else:
            yield from _measure_picture(chart, measure, measure.title)
    name, title = kind.modes
    svgs = (themed_svg(modes_figure(chart, title, sheet)) for sheet in SHEETS)
    yield Picture(name, f"{title}, as shares{_left_out(chart)}.", *svgs)
    if kind is LONE:
        yield from _maps(experiment)


def _measure_picture(
    chart: DesignPoints, measure: ReportedMeasure, title: str
) -> Iterator[Picture]:
    """Yield the picture of a measure if it has something to show."""
    figures = [measure_figure(chart, title, measure, sheet) for sheet in SHEETS]
    if svgs := [themed_svg(figure) for figure in figures if figure]:
        words = f"{title}: {measure.what}, {_intervals(chart, measure)}{_left_out(chart)}."
        yield Picture(measure.name, words, *svgs)


def _intervals(chart: DesignPoints, measure: ReportedMeasure) -> str:
    """Return which intervals a chart shows, and why some points have none."""
    drawn = [(each, interval) for each in chart.points if (interval := measured(measure, each))]
    known = any(interval.is_known for _, interval in drawn)
    method = "Wilson's" if measure is SUCCESS else "bootstrap"
    words = f"with {method} {CONFIDENCE:.0%} intervals" if known else "without intervals"
    pooled = "several combinations are pooled, which share their seeds"
    equal = "nearly all values are equal"
    why = dict.fromkeys(
        pooled
        if len(each.case_ids) > 1
        else f"fewer than {MIN_VALUES} {each.kind.counts}"
        if each.count < MIN_VALUES
        else equal
        for each, interval in drawn
        if not interval.is_known
    )
    if not why:
        return words
    return f"{words}{', but none where ' if known else ': '}{' or '.join(why)}"


def _left_out(chart: DesignPoints) -> str:
    """Return the end of a caption: what a chart does not show of its design."""
    roles, words = chart.roles, ""
    if roles.axis and len(roles.axis.values) < roles.values:
        words += f"; {len(roles.axis.values)} of {roles.values:,} values of {roles.axis.name}"
    if roles.pooled:
        names = listed([factor.name for factor in roles.pooled])
        is_pooled = any(len(results.case_ids) > 1 for results in chart.points)
        words += f"; {'pooled over' if is_pooled else 'of different'} {names}"
    case_ids = [number for each in chart.points for number in each.case_ids]
    return words + _numbers(chart.experiment, case_ids)


def _numbers(experiment: Experiment, case_ids: Sequence[int]) -> str:
    """Return the end of a caption: how many episodes the combinations have, if that differs."""
    counts = [experiment.results(case_id).episodes for case_id in case_ids]
    fewest, most = min(counts), max(counts)
    return f"; {fewest:,} to {most:,} episodes a combination" if fewest < most else ""


def _maps(experiment: Experiment) -> Iterator[Picture]:
    """Yield a heat map for each layout and its stations, the one with most episodes first."""
    layouts: dict[tuple[tuple[str, ...], str], list[int]] = {}
    for case_id, case in experiment.cases.items():
        if TILES in case and cells_of(case) <= MAX_CELLS:
            layouts.setdefault((tuple(case[TILES]), case["stations"]), []).append(case_id)
    most_first = sorted(layouts.items(), key=lambda each: -experiment.results(*each[1]).episodes)
    for number, ((rows, stations), ids) in enumerate(most_first[:MAX_MAPS], start=1):
        stuck = stuck_cells(experiment.store, rows, ids)
        if not stuck:
            continue
        episodes = experiment.results(*ids).episodes
        name, is_kept = shown(experiment.cases[ids[0]]["layout"]), stations == "kept"
        caption = (
            f"Where robots got stuck on layout {name}: of {counted(episodes, 'episode')} those of "
            "each failure mode, by the cell where they were stuck or ended"
            f"{_numbers(experiment, ids)}. {STATIONS[stations]}."
        )
        maps = (
            themed_svg(stuck_heat_map(rows, stuck, episodes, sheet, with_stations=is_kept))
            for sheet in SHEETS
        )
        yield Picture(f"stuck-{number}", caption, *maps)


MAX_COLORS, MAX_PANELS = 8, 6

MAX_POINTS = 400
"""Most points of a chart; each takes a bootstrap, and more could not be distinguished."""


class Roles(NamedTuple):
    """The factors along the axis, of the lines and of the panels, if any; others are pooled.

    The axis has the values that are drawn, of so many in all.
    """

    axis: Factor | None
    color: Factor | None
    panel: Factor | None
    pooled: tuple[Factor, ...]
    values: int = 0


def roles_of(design: Design) -> Roles:
    """Return which factor of a design is drawn where."""
    if not design.factors:
        return Roles(None, None, None, ())
    *left, axis = sorted(design.factors, key=lambda each: (each.is_ordered, len(each.values)))
    left.sort(key=lambda each: len(each.values))
    color = left.pop(0) if left and len(left[0].values) < MAX_COLORS else None
    panel = left.pop(0) if left and len(left[0].values) < MAX_PANELS else None
    lines = math.prod(len(each.values) for each in (color, panel) if each)
    count = len(axis.values)
    drawn = min(count, max(MAX_POINTS // lines, 2))
    # The first, the last, and those at equal distances between them.
    values = tuple(axis.values[number * (count - 1) // (drawn - 1)] for number in range(drawn))
    return Roles(Factor(axis.name, values), color, panel, tuple(left), count)


Where = tuple[Value | None, Value | None]
"""The values of the panel and of the colour."""


class DesignPoints:
    """The results of a design as points of a chart.

    Attributes:
        roles: Factors along the axis, of the colours and of the panels.
        lines: Results by the value along the axis, for each panel and colour; those at ``None``
            are the same along the whole axis.
        points: Results of all lines.
    """

    def __init__(self, experiment: Experiment, design: Design) -> None:
        self.experiment, self.roles = experiment, roles_of(design)
        roles = self.roles.panel, self.roles.color, self.roles.axis
        found: dict[Where, dict[Value | None, list[int]]] = {}
        for case_id, labels in design.labels.items():
            panel, color, along = (labels[role.name] if role else None for role in roles)
            found.setdefault((panel, color), {}).setdefault(along, []).append(case_id)
        panels, colors, values = (role.values if role else () for role in roles)
        self.lines = {
            where: {
                value: experiment.results(*found[where][value])
                for value in (*values, None)
                if value in found[where]
            }
            for where in product((None, *panels), (None, *colors))
            if where in found
        }
        self.points = [results for line in self.lines.values() for results in line.values()]


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


class PaperSize(NamedTuple):
    """Width of a figure in inches, and most panels side by side."""

    width: float
    panels: int


WIDE, PHONE = SHEETS = PaperSize(9.0, 3), PaperSize(3.4, 1)
"""Sheets for desktops and paper, and for phones 360 CSS pixels wide."""


class Panels(NamedTuple):
    """A figure, the axes of its panels, and the letters that fit along one of them."""

    figure: SceneFigure
    axes: list[Axes]
    letters: int
    legend: tuple[int, float]
    """Columns of the legend, and its distance from the top in inches."""


def make_panels(sheet: PaperSize, title: str, count: int, keys: Sequence[str]) -> Panels:
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


def _legend_columns(sheet: PaperSize, labels: Sequence[str]) -> int:
    longest = max(map(len, labels), default=0) + KEY_LETTERS
    return min(max(int(sheet.width * LETTERS) // longest, 1), MAX_LEGEND_COLUMNS)


MARKERS = "os^Dv*PX"

DODGE = 0.012
"""Distance between lines as a share of the width, so that no interval hides another."""


@mpl.rc_context({"text.parse_math": False})
def measure_figure(
    chart: DesignPoints, title: str, measure: ReportedMeasure, sheet: PaperSize = WIDE
) -> SceneFigure | None:
    """Draw a measure with its intervals, unless nothing differs or there is nothing to measure."""
    roles = chart.roles
    if roles.axis is None:
        return None
    lines = {
        where: {value: measured(measure, results) for value, results in line.items()}
        for where, line in chart.lines.items()
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


MODE_COLORS = {
    mode: PALETTE["both"][name]
    for mode, name in (
        (DELIVERED, "delivered"),
        (modes.UNREACHABLE, "unreachable"),
        (modes.STALLED, "stalled"),
        (modes.INEFFECTIVE, "ineffective"),
        (modes.OSCILLATION, "oscillation"),
        (modes.WANDERING, "wandering"),
        (BATTERY_DEPLETED, "out-of-battery"),
        (OUT_OF_TIME, "out-of-time"),
        (UNFINISHED, "unfinished"),
        (modes.SERVED, "delivered"),
        (modes.STRANDED, "out-of-battery"),
        (modes.DEADLOCK, "oscillation"),
        (modes.STARVATION, "stalled"),
        (modes.CONGESTED, "wandering"),
        (modes.IDLE, "unfinished"),
        (modes.LATE, "out-of-time"),
    )
}
"""Colours of how an episode ended; no chart has an episode of a lone robot and one of a fleet."""

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear R, G and B. Source: WCAG 2.2, relative luminance."""

MAX_DARK = 0.17
"""Luminance of the colours on which black and nearly white have the same contrast."""

MIN_LEGIBLE = 0.08
"""Minimum share of a bar for a number to fit into it."""

BAR_LETTERS = 5
"""Least letters along a panel for each bar for a number to fit into it."""


@mpl.rc_context({"text.parse_math": False})
def modes_figure(chart: DesignPoints, title: str, sheet: PaperSize = WIDE) -> SceneFigure:
    """Draw the shares of the outcomes as stacked bars."""
    roles, lines = chart.roles, chart.lines
    everywhere = f"any {roles.axis.name}" if roles.axis else "all episodes"
    occurring = {mode for results in chart.points for mode in results.modes}
    panels = make_panels(sheet, title, len(lines), list(occurring))
    most = panels.letters // BAR_LETTERS
    for (panel, color), line, each in zip(lines, lines.values(), panels.axes, strict=True):
        for place, results in enumerate(line.values()):
            _draw_bar(each, place, results, is_numbered=len(line) <= most)
        names = [everywhere if value is None else shown(value) for value in line]
        step, shortened = fitting(names, panels.letters)
        each.set_xticks(range(0, len(names), step), shortened)
        each.set_xlabel(roles.axis.name if roles.axis and [*line] != [None] else "", **SMALL)
        each.yaxis.set_major_formatter(PercentFormatter(1))
        each.set_ylim(0, 1)
        each.set_xlim(-0.6, max(len(names) - 0.4, 2.4))
        name_panel(each, (roles.panel, panel), (roles.color, color))
    colors = {mode: color for mode, color in MODE_COLORS.items() if mode in occurring}
    draw_legend(panels, [(mode, Patch(color=color)) for mode, color in colors.items()])
    return panels.figure


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
    """Return black or nearly white, whichever is legible on a colour.

    It is not ``PAPER``, which is dark on a dark page.
    """
    light = sum(weight * part**2.2 for weight, part in zip(LUMINANCE, to_rgb(color), strict=True))
    return "black" if light > MAX_DARK else "whitesmoke"


STUCK = f"""
SELECT mode, row, col, count(*) FROM episodes
WHERE case_id IN (SELECT value FROM json_each(?)) AND mode != '{DELIVERED}'
GROUP BY mode, row, col
"""


MAX_WIDTH = 7.4
"""Inches between the margins of A4 paper, which does not make the small text of a map smaller."""


def stuck_cells(
    store: Store, rows: Sequence[str], case_ids: Sequence[int]
) -> dict[str, CellCounts]:
    """Count the cells ``[H, W]`` where episodes ended or were stuck, by mode in their usual order.

    An episode that was stuck where the layout of the cases has no cell is a ``StoreError``.
    """
    stuck: dict[str, CellCounts] = {}
    for mode, row, col, count in store.query(STUCK, json.dumps(list(case_ids))):
        counts = stuck.setdefault(mode, np.zeros((len(rows), len(rows[0])), dtype=np.int64))
        if not (0 <= row < len(rows) and 0 <= col < len(rows[0])):
            raise StoreError(f"{store.path}: row {row}, column {col} is off the layout")
        counts[row, col] = count
    return {mode: stuck[mode] for mode in modes.MODES if mode in stuck}


def stuck_heat_map(
    rows: Sequence[str],
    stuck: Mapping[str, CellCounts],
    episodes: int,
    sheet: PaperSize = WIDE,
    *,
    with_stations: bool = False,
) -> Figure:
    """Return the heat maps of a layout, one panel for each mode that ``stuck_cells`` gives.

    Shares are of all episodes, deliveries included.
    """
    titled = {
        f"{mode}: {cells.sum():,} ({cells.sum() / episodes:.1%})": cells
        for mode, cells in stuck.items()
    }
    width = min(sheet.width, MAX_WIDTH)
    return heat_map(rows, titled, width=width, with_stations=with_stations)


DARK = {
    **{light: PALETTE["dark"][name] for name, light in PALETTE["light"].items() if name != "rim"},
    **dict(zip(PALETTE["series"]["light"], PALETTE["series"]["dark"], strict=True)),
    **{to_hex(HEAT(level)): to_hex(DARK_HEAT(level)) for level in range(HEAT.N)},
}
"""Colours of a dark page by the colours of a light one; others are the same on both.

Rims are left out: no figure has them, and letters that stay dark have their colour.
"""

SVG_START = re.compile(rb"<svg [^>]*>")

USED = re.compile(rb"(fill|stroke): (#[0-9a-f]{6})")


def themed_svg(figure: Figure) -> bytes:
    """Return a figure as SVG that follows the reader's colour scheme."""
    file = BytesIO()
    save_svg(figure, file)
    svg = file.getvalue()
    used = sorted({(part.decode(), color.decode()) for part, color in USED.findall(svg)})
    rules = "".join(
        f'[style*="{part}: {color}"]{{{part}:{DARK[color]}!important}}'
        for part, color in used
        if color in DARK
    )
    style = f"<style>@media (prefers-color-scheme:dark){{{rules}}}</style>"
    return SVG_START.sub(lambda found: found[0] + style.encode(), svg, count=1)
