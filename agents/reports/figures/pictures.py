"""The figures of a report, each with its caption."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from operator import attrgetter

from matplotlib.figure import Figure

from agents.evaluation.interval import CONFIDENCE
from agents.experiments.case import TILES
from agents.experiments.parameters import shown
from agents.reports.analysis.design import Design, make_design
from agents.reports.analysis.results import Experiment
from agents.reports.figures.heat_map import heat_map, stuck_cells
from agents.reports.figures.measure import measure_chart
from agents.reports.figures.modes import modes_chart
from agents.reports.figures.roles import roles_of
from warehouse_core.viz.figure import save_svg
from warehouse_core.wording import counted, listed

MAX_MAPS = 4
"""Heat maps, of the layouts with most episodes."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as SVG with its caption; its name is the stem of its file."""

    name: str
    caption: str
    svg: bytes


def pictures(experiment: Experiment) -> Iterator[Picture]:
    """Yield the figures that are not empty."""
    design = make_design(experiment.cases)
    measured = make_design(
        {n: case for n, case in experiment.cases.items() if case["backend"] != "grid"}
    )
    backends = sorted({shown(labels["backend"]) for labels in measured.labels.values()})
    on = f", backend {listed(backends)}" if backends else ""
    for name, title, unit, of in (
        ("success", "Delivered", "%", design),
        ("steps", "Steps of a delivery", "steps", design),
        ("seconds", f"Time of a delivery{on}", "s", measured),
        ("joules", f"Energy of a delivery{on}", "J", measured),
    ):
        chart = measure_chart(experiment, of, title, unit, attrgetter(name))
        if chart is None:
            continue
        shares, means = "share of all episodes", "mean of what was delivered, hard or easy"
        what = f"{shares}, with Wilson's" if unit == "%" else f"{means}, with bootstrap"
        caption = f"{title}: {what} {CONFIDENCE:.0%} intervals{_left_out(of)}."
        yield Picture(name, caption, _svg(chart))
    figure = modes_chart(experiment, design, "What became of the episodes")
    caption = f"What became of the episodes, as shares{_left_out(design)}."
    yield Picture("modes", caption, _svg(figure))
    yield from _maps(experiment)


def _left_out(design: Design) -> str:
    """Return the end of a caption: what a chart does not show of a design."""
    roles = roles_of(design)
    words = ""
    if roles.axis and len(roles.axis.values) < roles.values:
        words += f"; {len(roles.axis.values)} of {roles.values:,} values of {roles.axis.name}"
    if roles.pooled:
        names = listed([factor.name for factor in roles.pooled])
        words += f"; pooled over {names}, so without intervals: the same seeds are in it many times"
    return words


def _maps(experiment: Experiment) -> Iterator[Picture]:
    """Yield a heat map for each layout, the one with most episodes first."""
    layouts: dict[tuple[str, ...], list[int]] = {}
    for case_id, case in experiment.cases.items():
        if TILES in case:
            layouts.setdefault(tuple(case[TILES]), []).append(case_id)
    most_first = sorted(layouts.items(), key=lambda each: -experiment.results(*each[1]).episodes)
    for number, (rows, ids) in enumerate(most_first[:MAX_MAPS], start=1):
        stuck = stuck_cells(experiment.store, rows, ids)
        if not stuck:
            continue
        episodes = experiment.results(*ids).episodes
        name = shown(experiment.cases[ids[0]]["layout"])
        caption = (
            f"Where robots got stuck on layout {name}: of {counted(episodes, 'episode')} those of "
            "each failure mode, by the cell where they were stuck or ended. Pickup and dropoff are "
            "random in each episode."
        )
        yield Picture(f"stuck-{number}", caption, _svg(heat_map(rows, stuck, episodes)))


def _svg(figure: Figure) -> bytes:
    file = BytesIO()
    save_svg(figure, file)
    return file.getvalue()
