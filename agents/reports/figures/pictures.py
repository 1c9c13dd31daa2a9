"""The figures of a report, each with its caption."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO

from matplotlib.figure import Figure

from agents.evaluation.interval import CONFIDENCE, Interval
from agents.experiments.case import TILES
from agents.experiments.parameters import shown
from agents.reports.analysis.design import Design, make_design
from agents.reports.analysis.results import Experiment, Results
from agents.reports.figures.heat_map import heat_map, stuck_cells
from agents.reports.figures.measure import measure_chart
from agents.reports.figures.modes import modes_chart
from agents.reports.figures.roles import roles_of
from warehouse_core.viz.figure import save_svg
from warehouse_core.wording import counted, listed
from warehouse_core.world.tiles import DROPOFF, EMPTY, PICKUP

MAX_MAPS = 4
"""Heat maps, of the layouts with most episodes."""

SHARE = "%"
"""The unit of shares."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure.

    Attributes:
        name: the stem of its file.
        caption: what it shows.
        svg: the file.
    """

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
    for name, title, unit, measure, of in (
        ("success", "Delivered", SHARE, lambda results: results.success, design),
        ("steps", "Steps of a delivery", "steps", lambda results: results.steps, design),
        ("seconds", f"Time of a delivery{on}", "s", lambda results: results.seconds, measured),
        ("joules", f"Energy of a delivery{on}", "J", lambda results: results.joules, measured),
    ):
        yield from _measured(experiment, of, name, title, unit, measure)
    figure = modes_chart(experiment, design, "What became of the episodes")
    caption = f"What became of the episodes, as shares{_left_out(design)}."
    yield Picture("modes", caption, _svg(figure))
    yield from _maps(experiment)


def _measured(
    experiment: Experiment,
    design: Design,
    name: str,
    title: str,
    unit: str,
    measure: Callable[[Results], Interval | None],
) -> Iterator[Picture]:
    figure = measure_chart(experiment, design, title, unit, measure)
    if figure is None:
        return
    kind = "Wilson's" if unit == SHARE else "bootstrap"
    of = "share of all episodes" if unit == SHARE else "mean of what was delivered, hard or easy"
    caption = f"{title}: {of}, with {kind} {CONFIDENCE:.0%} intervals{_left_out(design)}."
    yield Picture(name, caption, _svg(figure))


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
    counted_layouts = sorted(
        ((experiment.results(*ids).episodes, rows, ids) for rows, ids in layouts.items()),
        key=lambda each: -each[0],
    )
    for number, (episodes, rows, ids) in enumerate(counted_layouts[:MAX_MAPS], start=1):
        # Stations are random in each episode; those of the file are not used.
        walls = [row.replace(PICKUP, EMPTY).replace(DROPOFF, EMPTY) for row in rows]
        stuck = stuck_cells(experiment.store, ids)
        if not stuck:
            continue
        name = shown(experiment.cases[ids[0]]["layout"])
        caption = (
            f"Where robots got stuck on layout {name}: of {counted(episodes, 'episode')} those of "
            "each failure mode, by the cell where they were stuck or ended. Pickup and dropoff are "
            "random in each episode."
        )
        yield Picture(f"stuck-{number}", caption, _svg(heat_map(walls, stuck, episodes)))


def _svg(figure: Figure) -> bytes:
    file = BytesIO()
    save_svg(figure, file)
    return file.getvalue()
