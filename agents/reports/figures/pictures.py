"""The figures of a report, each with its caption."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from operator import attrgetter

from matplotlib.figure import Figure

from agents.evaluation.interval import CONFIDENCE, MIN_VALUES
from agents.experiments.case import TILES, cells_of
from agents.experiments.parameters import shown
from agents.reports.analysis.design import Design, make_design
from agents.reports.analysis.results import Experiment, Results
from agents.reports.figures.heat_map import stuck_cells, stuck_heat_map
from agents.reports.figures.measure import Measure, measure_chart, measured
from agents.reports.figures.modes import modes_chart
from agents.reports.figures.roles import lines_of, roles_of
from warehouse_core.viz.figure import save_svg
from warehouse_core.wording import counted, listed

MAX_MAPS = 4
"""Heat maps, of the layouts with most episodes."""

MAX_CELLS = 300_000
"""Of a layout that has a heat map or a replay; in a larger one no cell could be seen."""

STATIONS = {"drawn": "random in each episode", "kept": "those of the layout in every episode"}


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as SVG with its caption; its name is the stem of its file."""

    name: str
    caption: str
    svg: bytes


def pictures(experiment: Experiment) -> Iterator[Picture]:
    """Yield the figures that are not empty."""
    design = make_design(experiment.cases)
    physical = make_design(
        {n: case for n, case in experiment.cases.items() if case["backend"] != "grid"}
    )
    backends = sorted({shown(labels["backend"]) for labels in physical.labels.values()})
    on = f", backend {listed(backends)}" if backends else ""
    for name, title, unit, of in (
        ("success", "Delivered", "%", design),
        ("steps", "Steps of a delivery", "steps", design),
        ("seconds", f"Time of a delivery{on}", "s", physical),
        ("joules", f"Energy of a delivery{on}", "J", physical),
    ):
        chart = measure_chart(experiment, of, title, unit, attrgetter(name))
        if chart is None:
            continue
        points = _points(experiment, of)
        shares, means = "share of all episodes", "mean of what was delivered, hard or easy"
        what, method = (shares, "Wilson's") if unit == "%" else (means, "bootstrap")
        intervals = _intervals(points, attrgetter(name), method)
        caption = f"{title}: {what}, {intervals}{_left_out(experiment, of, points)}."
        yield Picture(name, caption, _svg(chart))
    figure = modes_chart(experiment, design, "What became of the episodes")
    left_out = _left_out(experiment, design, _points(experiment, design))
    caption = f"What became of the episodes, as shares{left_out}."
    yield Picture("modes", caption, _svg(figure))
    yield from _maps(experiment)


def _points(experiment: Experiment, design: Design) -> list[Results]:
    lines = lines_of(experiment, design, roles_of(design)).values()
    return [results for line in lines for results in line.values()]


def _intervals(points: Sequence[Results], measure: Measure, method: str) -> str:
    """Return which intervals a chart shows, and why some points have none."""
    found = [(each, interval) for each in points if (interval := measured(measure, each))]
    known = any(interval.is_known for _, interval in found)
    words = f"with {method} {CONFIDENCE:.0%} intervals" if known else "without intervals"
    pooled = "several combinations are pooled, which share their seeds"
    few = f"fewer than {MIN_VALUES} were delivered"
    equal = "nearly all values are equal"
    why = dict.fromkeys(
        pooled if len(each.case_ids) > 1 else few if each.delivered < MIN_VALUES else equal
        for each, interval in found
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
        name = shown(experiment.cases[ids[0]]["layout"])
        caption = (
            f"Where robots got stuck on layout {name}: of {counted(episodes, 'episode')} those of "
            "each failure mode, by the cell where they were stuck or ended"
            f"{_numbers(experiment, ids)}. Pickup and dropoff are {STATIONS[stations]}."
        )
        yield Picture(f"stuck-{number}", caption, _svg(stuck_heat_map(rows, stuck, episodes)))


def _svg(figure: Figure) -> bytes:
    file = BytesIO()
    save_svg(figure, file)
    return file.getvalue()
