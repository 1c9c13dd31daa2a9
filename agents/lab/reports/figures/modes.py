"""The chart of how the episodes of each case ended."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from agents.lab.parameters import shown
from agents.lab.reports.analysis.results import Experiment, Results
from agents.lab.reports.figures.panels import (
    SMALL,
    TEXT_SIZE,
    WIDE,
    Sheet,
    draw_legend,
    fitting,
    make_panels,
    name_panel,
)
from agents.lab.reports.figures.roles import lines_of, roles_of
from warehouse_core.records import failure_modes as modes
from warehouse_core.records.episode import BATTERY_DEPLETED, DELIVERED, OUT_OF_TIME, UNFINISHED
from warehouse_core.render.palette import PALETTE, PAPER
from warehouse_core.viz.figure import SceneFigure

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
def modes_chart(experiment: Experiment, title: str, sheet: Sheet = WIDE) -> SceneFigure:
    """Draw the shares of the outcomes as stacked bars."""
    roles = roles_of(experiment.design)
    lines = lines_of(experiment, experiment.design, roles)
    everywhere = f"any {roles.axis.name}" if roles.axis else "all episodes"
    occurring = {mode for line in lines.values() for each in line.values() for mode in each.modes}
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
