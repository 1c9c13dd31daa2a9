"""Curves over the number of robots, with a panel for each set and a line for each algorithm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

from agents.lab.commands.pogema.benchmark import Kind
from agents.lab.commands.pogema.published import published
from agents.lab.commands.pogema.summary import Group, Score
from agents.lab.reports.design import Factor
from agents.lab.reports.figures import (
    DODGE,
    MARKERS,
    SHEETS,
    SMALL,
    Picture,
    Sheet,
    draw_legend,
    make_panels,
    places_of,
    prepare_axis,
    themed_svg,
)
from agents.lab.trials.interval import MIN_VALUES, Interval, mean_interval, share_interval
from warehouse_core.render.palette import FAINT, SERIES
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.wording import printable

DASHES = (0, (4, 1.6))
"""Style of the lines of published algorithms."""


class Curve(NamedTuple):
    """A measure of scores that is drawn.

    Attributes:
        of: function that returns it for a score of a group; ``None`` where it is unknown.
        unit: name of its axis; ``%`` for shares.
        least: lower end of its axis; ``None`` for a logarithmic one.
    """

    kind: Kind
    name: str
    title: str
    caption: str
    of: Callable[[Group, Score], Interval | None]
    unit: str
    least: float | None = 0.0


def _solved(group: Group, score: Score) -> Interval | None:
    if score.episodes < MIN_VALUES:
        return Interval(score.solved / score.episodes)
    return share_interval(score.solved, score.episodes)


def _over_bound(group: Group, score: Score) -> Interval | None:
    return mean_interval(score.ratios(group.bound))


def _rate(group: Group, score: Score) -> Interval | None:
    return mean_interval(score.values[np.isfinite(score.values)])


def _seconds(group: Group, score: Score) -> Interval | None:
    return Interval(score.seconds) if score.seconds > 0 else None


CLOCK = "Seconds of an episode: processor time here, by the clock of published algorithms (dashed)."

CURVES = (
    Curve(
        Kind.ONE_SHOT, "solved", "Episodes solved",
        "Episodes in which all robots reach their goals within the benchmark's limit of steps, "
        "with Wilson's 95% intervals from 20 episodes on. Published algorithms are dashed, on the "
        "same episodes.",
        _solved, "%",
    ),
    Curve(
        Kind.ONE_SHOT, "costs", "Costs over the sum of the shortest ways",
        "Sum of costs over the lower bound: means over the episodes that each solves itself, which "
        "are the easier ones where it solves few.",
        _over_bound, "times the bound", 1.0,
    ),
    Curve(Kind.ONE_SHOT, "seconds", "Seconds for a plan", CLOCK, _seconds, "s", None),
    Curve(
        Kind.LIFELONG, "throughput", "Goals reached in a step",
        "Goals that all robots together reach in a step, means with 95% intervals from 20 "
        "episodes on. Published algorithms are dashed, on the same episodes.",
        _rate, "goals a step",
    ),
    Curve(Kind.LIFELONG, "time", "Seconds for an episode", CLOCK, _seconds, "s", None),
)  # fmt: skip


def pictures(groups: Sequence[Group]) -> list[Picture]:
    """Return a picture of each measure that has something to show."""
    found = []
    for curve in CURVES:
        mine = [group for group in groups if group.kind is curve.kind]
        if mine:
            charts = (themed_svg(curves_figure(curve, mine, sheet)) for sheet in SHEETS)
            found.append(Picture(curve.name, curve.caption, *charts))
    return found


@mpl.rc_context({"text.parse_math": False})
def curves_figure(curve: Curve, groups: Sequence[Group], sheet: Sheet) -> SceneFigure:
    """Draw a measure of some groups, which are of one kind."""
    sets = list(dict.fromkeys(group.collection for group in groups))
    names = list(dict.fromkeys(name for group in groups for name in group.scores))
    labels = [printable(name) for name in names]
    panels = make_panels(sheet, f"{curve.title}, {curve.kind}", len(sets), labels)
    keys: dict[str, Any] = {}
    for collection, axes in zip(sets, panels.axes, strict=True):
        mine = [group for group in groups if group.collection == collection]
        axis = _axis(mine)
        places = places_of(axis)
        for number, name in enumerate(names):
            key = _draw_line(axes, curve, mine, name, list(places.values()), number, len(names))
            if key is not None:
                keys.setdefault(printable(name), key)
        prepare_axis(axes, axis, places, panels.letters)
        axes.set_title(collection, loc="left", **SMALL)
        axes.grid(axis="y", color=FAINT, linewidth=0.5)
        if curve.unit == "%":
            axes.yaxis.set_major_formatter(PercentFormatter(1))
    # All panels share this axis, so that its limits are known when all lines are drawn.
    first = panels.axes[0]
    if curve.unit == "%":
        first.set_ylim(-0.02, 1.04)
    else:
        first.set_ylabel(curve.unit, **SMALL)
        if curve.least is None:
            first.set_yscale("log")
        else:
            first.set_ylim(bottom=curve.least)
    draw_legend(panels, list(keys.items()))
    return panels.figure


def _axis(groups: Sequence[Group]) -> Factor:
    """Return the axis of the numbers of robots; one alone is a name, which needs no scale."""
    sizes = [group.robots for group in groups]
    return Factor("robots", tuple(sizes) if len(sizes) > 1 else tuple(map(str, sizes)))


def _draw_line(
    axes: Axes,
    curve: Curve,
    groups: Sequence[Group],
    name: str,
    places: Sequence[float],
    number: int,
    count: int,
) -> Any:
    """Draw the line of an algorithm and return what a legend shows of it; ``None`` without one."""
    points = [
        (place, point)
        for place, group in zip(places, groups, strict=True)
        if name in group.scores and (point := curve.of(group, group.scores[name])) is not None
    ]
    if not points:
        return None
    shift = (number - (count - 1) / 2) * DODGE * (places[-1] or 10 * DODGE)
    ends = np.array([(each.low, each.high) for _, each in points])
    middles = np.array([each.estimate for _, each in points])
    reach = np.nan_to_num(np.abs(ends - middles[:, None])).T
    return axes.errorbar(
        [place + shift for place, _ in points], middles, reach, capsize=2.5, markersize=6,
        fmt=MARKERS[number % len(MARKERS)], color=SERIES[number % len(SERIES)], linewidth=2.0,
        linestyle=DASHES if is_published(groups, name) else "-",
    )  # fmt: skip


def is_published(groups: Sequence[Group], name: str) -> bool:
    """Return whether an algorithm is one of the published ones."""
    return any(name in published().get(group[:3], {}) for group in groups)
