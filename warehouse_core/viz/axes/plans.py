"""Plans ahead of robots, and who pushes whom."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray

from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import COLORS, INK, PAPER, Color, blend
from warehouse_core.world.tiles import EMPTY

PLAN_STYLE, WISH_STYLE = "-", (0, (0.1, 1.6))
"""Line styles of a plan, and of the way from its end to the goal, which is not planned yet."""

FADE_STEPS, MAX_FADE = 20, 0.75
"""Steps over which a plan fades, and how much of the floor's colour it then has."""

ARROW = np.array([(0.27, 0), (-0.05, 0.21), (-0.05, 0.08), (-0.27, 0.08)])
"""Half an arrow that points right, around the middle between two robots, in cells."""

Points = NDArray[np.float64]


class PlanView:
    """Collections for axes whose unit is a cell: ``ways``, ``wishes`` and arrows of ``pushes``.

    A cell has a side of ``cell_points`` points; ``zorder`` is the drawing order of the robots.
    """

    def __init__(self, cell_points: float, zorder: float) -> None:
        width = max(2.0, cell_points / 6)
        self.ways, self.wishes = (
            LineCollection(
                [], linestyles=[style], linewidths=wide, capstyle="round", zorder=zorder - 0.5
            )
            for style, wide in ((PLAN_STYLE, width), (WISH_STYLE, 0.8 * width))
        )
        self.pushes = PolyCollection(
            [], facecolors=[INK], edgecolors=[PAPER], linewidths=min(0.8, cell_points / 24),
            zorder=zorder + 2,
        )  # fmt: skip

    def show(self, plans: StepPlans, places: Points, colors: Sequence[Color]) -> None:
        """Draw plans of robots whose middles are at ``places``, ``[R, 2]``."""
        for lines, ways, is_wish in (
            (self.ways, plans.ways, False), (self.wishes, plans.wishes, True),
        ):  # fmt: skip
            segments, faded = list[Any](), list[Color]()
            for robot, way in ways.items():
                first = len(plans.ways.get(robot, ())) - 1 if is_wish else 0
                for time, (before, after) in enumerate(pairwise(way), first):
                    if before != after:
                        segments.append([(col + 0.5, row + 0.5) for row, col in (before, after)])
                        share = min(time / FADE_STEPS, 1) * MAX_FADE
                        faded.append(blend(colors[robot], COLORS[EMPTY], share))
            lines.set_segments(segments)
            lines.set_color(faded)
        self.pushes.set_verts(
            [_arrow(places[pusher], places[robot]) for robot, pusher in plans.pushers.items()]
        )


def _arrow(start: Points, end: Points) -> Points:
    """Return the corners of an arrow half way between two places."""
    ahead = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    aside = np.array([-ahead[1], ahead[0]])
    whole = np.vstack([ARROW, ARROW[:0:-1] * (1, -1)])
    corners: Points = (start + end) / 2 + whole[:, :1] * ahead + whole[:, 1:] * aside
    return corners
