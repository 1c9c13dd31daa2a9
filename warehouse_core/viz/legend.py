"""The legend of a replay: tiles, robots, trails, hits and, for a belief, what is not seen."""

from __future__ import annotations

from matplotlib.artist import Artist
from matplotlib.figure import SubFigure
from matplotlib.legend import Legend
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
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED


def draw_legend(figure: SceneFigure | SubFigure, *, has_belief: bool = False) -> Legend:
    """Draw the legend along the bottom of a figure.

    Args:
        figure: to draw into.
        has_belief: explain cells not seen yet, and the plan.
    """
    handles: list[Artist] = []
    labels = []
    for character, meaning in LEGEND.items():
        is_robot = character in (ROBOT_EMPTY, ROBOT_LOADED)
        handles.append(
            Line2D([], [], marker="o" if is_robot else "s", markersize=10, linestyle="none",
                   markerfacecolor=COLORS[character], markeredgecolor=INK, markeredgewidth=0.6)
        )  # fmt: skip
        labels.append(f"{character}  {meaning}")
    for loaded, color in TRAIL_COLORS.items():
        handles.append(Line2D([], [], color=color, linestyle=TRAIL_STYLES[loaded], lw=2.2))
        labels.append(f"trail {'loaded' if loaded else 'empty'}")
    handles.append(
        Line2D([], [], marker="*", markersize=11, linestyle="none", color=HIT, mec=INK, mew=0.6)
    )
    labels.append("hit")
    if has_belief:
        handles.append(
            Rectangle((0, 0), 1, 1, facecolor=UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="//////")
        )
        handles.append(Line2D([], [], color=INK, linestyle=ROUTE_STYLE, lw=2.2))
        labels += ["not seen yet", "plan"]
    return figure.legend(
        handles, labels, loc="lower center", ncols=6 if has_belief else 5, fontsize=8,
        frameon=False, handlelength=2.0, columnspacing=1.4, handletextpad=0.5,
    )  # fmt: skip
