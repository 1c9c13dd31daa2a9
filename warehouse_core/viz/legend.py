"""The legend of a replay: tiles, robots, trails, hits and, for a belief, what is not seen."""

from __future__ import annotations

from typing import Any

from matplotlib.artist import Artist
from matplotlib.figure import SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import (
    COLORS,
    HIT,
    INK,
    TRAIL_COLORS,
    TRAIL_STYLES,
    UNKNOWN,
    UNKNOWN_STRIPE,
)
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.grid_view import ROUTE_STYLE
from warehouse_core.warehouse_env import legend
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED


def draw_legend(
    figure: SceneFigure | SubFigure, *, has_chargers: bool, has_belief: bool = False
) -> None:
    """Draw the legend along the bottom of a figure.

    Args:
        figure: to draw into.
        has_chargers: explain chargers.
        has_belief: explain cells not seen yet, and the plan.
    """
    edge: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}
    signs: dict[str, Artist] = {}
    for character, meaning in legend(has_chargers).items():
        marker = "o" if character in (ROBOT_EMPTY, ROBOT_LOADED) else "s"
        color = COLORS[character]
        signs[f"{character}  {meaning}"] = Line2D(
            [], [], marker=marker, markersize=10, markerfacecolor=color, **edge
        )
    for loaded, color in TRAIL_COLORS.items():
        line = Line2D([], [], color=color, linestyle=TRAIL_STYLES[loaded], lw=2.2)
        signs[f"trail {'loaded' if loaded else 'empty'}"] = line
    signs["hit"] = Line2D([], [], marker="*", markersize=11, color=HIT, **edge)
    if has_belief:
        signs["not seen yet"] = Rectangle(
            (0, 0), 1, 1, facecolor=UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="//////"
        )
        signs["plan"] = Line2D([], [], color=INK, linestyle=ROUTE_STYLE, lw=2.2)
    figure.legend(
        [*signs.values()], [*signs], loc="lower center", ncols=6 if has_belief else 5, fontsize=8,
        frameon=False, handlelength=2.0, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip
