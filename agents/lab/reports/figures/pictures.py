"""The figures of a report, each with its caption."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from agents.lab.experiments.case import TILES, cells_of
from agents.lab.parameters import shown
from agents.lab.reports.analysis.design import Design, make_design
from agents.lab.reports.analysis.results import LONE, SUCCESS, Experiment, ReportedMeasure, Results
from agents.lab.reports.figures.dark import themed_svg
from agents.lab.reports.figures.heat_map import stuck_cells, stuck_heat_map
from agents.lab.reports.figures.measure import measure_chart, measured
from agents.lab.reports.figures.modes import modes_chart
from agents.lab.reports.figures.panels import SHEETS
from agents.lab.reports.figures.roles import lines_of, roles_of
from agents.lab.trials.interval import CONFIDENCE, MIN_VALUES
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
    design, kind = experiment.design, experiment.kind
    physical = make_design(
        {n: case for n, case in experiment.cases.items() if case["backend"] != "grid"}
    )
    backends = sorted({shown(labels["backend"]) for labels in physical.labels.values()})
    on = f", backend {listed(backends)}" if backends else ""
    for measure in kind.measures:
        if measure.is_physical:
            yield from _chart(experiment, physical, measure, measure.title + on)
        else:
            yield from _chart(experiment, design, measure, measure.title)
    name, title = kind.modes
    left_out = _left_out(experiment, design, _points(experiment, design))
    charts = (themed_svg(modes_chart(experiment, title, sheet)) for sheet in SHEETS)
    yield Picture(name, f"{title}, as shares{left_out}.", *charts)
    if kind is LONE:
        yield from _maps(experiment)


def _chart(
    experiment: Experiment, design: Design, measure: ReportedMeasure, title: str
) -> Iterator[Picture]:
    """Yield the chart of a measure if it has something to show."""
    charts = [
        themed_svg(chart)
        for sheet in SHEETS
        if (chart := measure_chart(experiment, design, title, measure, sheet))
    ]
    if charts:
        points = _points(experiment, design)
        caption = (
            f"{title}: {measure.what}, {_intervals(points, measure)}"
            f"{_left_out(experiment, design, points)}."
        )
        yield Picture(measure.name, caption, *charts)


def _points(experiment: Experiment, design: Design) -> list[Results]:
    lines = lines_of(experiment, design, roles_of(design)).values()
    return [results for line in lines for results in line.values()]


def _intervals(points: Sequence[Results], measure: ReportedMeasure) -> str:
    """Return which intervals a chart shows, and why some points have none."""
    drawn = [(each, interval) for each in points if (interval := measured(measure, each))]
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


def _left_out(experiment: Experiment, design: Design, points: Sequence[Results]) -> str:
    """Return the end of a caption: what a chart does not show of a design."""
    roles = roles_of(design)
    words = ""
    if roles.axis and len(roles.axis.values) < roles.values:
        words += f"; {len(roles.axis.values)} of {roles.values:,} values of {roles.axis.name}"
    if roles.pooled:
        names = listed([factor.name for factor in roles.pooled])
        is_pooled = any(len(results.case_ids) > 1 for results in points)
        words += f"; {'pooled over' if is_pooled else 'of different'} {names}"
    return words + _numbers(experiment, [number for each in points for number in each.case_ids])


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
