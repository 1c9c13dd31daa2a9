"""The legend of a replay: tiles, robots, trails, hits and, for a belief, what is not seen."""

from __future__ import annotations

from typing import Any

from matplotlib.artist import Artist
from matplotlib.figure import SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.records.plans import NO_PLANS, StepPlans
from warehouse_core.render.palette import (
    COLORS,
    HIT,
    INK,
    ORDER_COLORS,
    PAPER,
    STRANDED,
    TRAIL_COLORS,
    TRAIL_STYLES,
    UNKNOWN,
    UNKNOWN_STRIPE,
    WARNING,
)
from warehouse_core.viz.axes.plans import WISH_STYLE
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.grid_view import ROUTE_STYLE
from warehouse_core.warehouse_env import legend
from warehouse_core.world.tiles import PERSON, ROBOT_EMPTY, ROBOT_LOADED

ORDER_WORDS = (", new", ", older", ", nearly due", ", late (!)")


def draw_legend(
    figure: SceneFigure | SubFigure,
    *,
    has_chargers: bool,
    has_belief: bool = False,
    is_fleet: bool = False,
    plans: StepPlans = NO_PLANS,
) -> None:
    """Draw the legend along the bottom of a figure.

    Args:
        figure: to draw into.
        has_chargers: explain chargers.
        has_belief: explain cells not seen yet, and the plan.
        is_fleet: explain people, orders and batteries, and no trails.
        plans: explain what of them is not empty.
    """
    edge: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}
    signs: dict[str, Artist] = {}
    for character, meaning in legend(has_chargers).items():
        marker = "o" if character in (ROBOT_EMPTY, ROBOT_LOADED) else "s"
        color = COLORS[character]
        has_letter = marker == "s" or not is_fleet
        signs[f"{character}  {meaning}" if has_letter else meaning] = Line2D(
            [], [], marker=marker, markersize=10, markerfacecolor=color, **edge
        )
    if is_fleet:
        signs |= _fleet_signs(edge)
    for loaded, color in () if is_fleet else TRAIL_COLORS.items():
        line = Line2D([], [], color=color, linestyle=TRAIL_STYLES[loaded], lw=2.2)
        signs[f"trail {'loaded' if loaded else 'empty'}"] = line
    signs["blocked" if is_fleet else "hit"] = Line2D(
        [], [], marker="*", markersize=11, color=HIT, **edge
    )
    if has_belief:
        signs["not seen yet"] = Rectangle(
            (0, 0), 1, 1, facecolor=UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="//////"
        )
        signs["plan"] = Line2D([], [], color=INK, linestyle=ROUTE_STYLE, lw=2.2)
    signs |= _plan_signs(plans)
    figure.legend(
        [*signs.values()], [*signs], loc="lower center", fontsize=8, frameon=False,
        ncols=6 if is_fleet or has_belief else 5, handlelength=2.0, columnspacing=1.4,
        handletextpad=0.5,
    )  # fmt: skip


def _plan_signs(plans: StepPlans) -> dict[str, Artist]:
    """Return the signs of plans ahead of robots."""
    line: dict[str, Any] = {"color": COLORS[ROBOT_EMPTY], "lw": 3.0, "dash_capstyle": "round"}
    signs: dict[str, Artist] = {}
    if plans.ways:
        signs["plan"] = Line2D([], [], **line)
    if plans.wishes:
        signs["shortest way on"] = Line2D([], [], linestyle=WISH_STYLE, **line)
    if plans.pushers:
        signs["pushes"] = Line2D(
            [], [], linestyle="none", marker=">", markersize=9, color=INK, markeredgecolor=PAPER
        )
    return signs


def _fleet_signs(edge: dict[str, Any]) -> dict[str, Artist]:
    """Return the signs of what only fleets have."""
    marks = {
        "person": ("D", COLORS[PERSON]),
        **{
            f"order{words}": ("s", color)
            for words, color in zip(ORDER_WORDS, ORDER_COLORS, strict=True)
        },
        "battery empty": ("o", STRANDED),
    }
    signs: dict[str, Artist] = {
        words: Line2D([], [], marker=marker, markersize=8, markerfacecolor=color, **edge)
        for words, (marker, color) in marks.items()
    }
    signs["battery low"] = Line2D([], [], color=WARNING, lw=4.0, solid_capstyle="butt")
    return signs
