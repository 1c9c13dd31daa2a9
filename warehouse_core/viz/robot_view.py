"""One robot in a picture: a disc with its letter, its heading, and its trail."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text

from warehouse_core.render.palette import COLORS, INK, TRAIL_COLORS, TRAIL_STYLES
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.track import Pose
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED

ROBOT_RADIUS = 0.31
"""In cells; the letter in the corner of a tile stays readable."""

MIN_ROBOT_POINTS = 5.0
"""Minimum radius of a robot, for large grids with small cells."""

MIN_LETTER_POINTS = 6.0

ABOVE_TILES = 3
"""Drawing order in an SVG; pixels are drawn in the order of the movers."""


class RobotView:
    """Draws a robot into axes whose unit is a cell.

    Args:
        figure: to add the movers to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
    """

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float) -> None:
        width = max(1.0, cell_points / 11)
        self._trails = {
            loaded: axes.add_line(
                Line2D([], [], color=color, linestyle=TRAIL_STYLES[loaded], linewidth=width)
            )
            for loaded, color in TRAIL_COLORS.items()
        }
        self._radius = max(ROBOT_RADIUS, MIN_ROBOT_POINTS / cell_points)
        self._disc = axes.add_patch(
            Circle(
                (0, 0), self._radius, linewidth=max(0.5, cell_points / 22), edgecolor=INK,
                zorder=ABOVE_TILES,
            )
        )  # fmt: skip
        self._nose = axes.add_line(
            Line2D([], [], color=INK, linewidth=max(0.8, cell_points / 14), zorder=ABOVE_TILES)
        )
        self._letter = letter(
            axes, cell_points, 0, 0, "", 0.42, ha="center", va="center_baseline", zorder=ABOVE_TILES
        )
        for mover in (*self._trails.values(), self._disc, self._nose, self._letter):
            figure.add_mover(mover)

    def show(self, poses: Sequence[Pose | None]) -> None:
        """Draw the robot at the last of ``poses``, unless that is ``None``, and its trail there."""
        for loaded, line in self._trails.items():
            line.set_data(*_trail_of(poses, loaded))
        pose = poses[-1]
        for artist in (self._disc, self._nose, self._letter):
            artist.set_visible(pose is not None)
        if pose is None:
            return
        x, y = pose.at
        kind = ROBOT_LOADED if pose.loaded else ROBOT_EMPTY
        self._disc.set(center=(x, y), facecolor=COLORS[kind])
        self._letter.set(position=(x, y), text=kind, color=INK if pose.loaded else "white")
        if pose.heading is None:
            self._nose.set_data([], [])
        else:
            dx, dy = math.cos(pose.heading), math.sin(pose.heading)
            ends = (0.72 * self._radius, 1.25 * self._radius)
            self._nose.set_data([x + r * dx for r in ends], [y + r * dy for r in ends])


def letter(
    axes: Axes, cell_points: float, x: float, y: float, text: str, share: float, **options: Any
) -> Text:
    """Add a letter whose height is a share of a cell, but at least ``MIN_LETTER_POINTS``."""
    size = max(MIN_LETTER_POINTS, share * cell_points)
    return axes.text(x, y, text, fontsize=size, fontweight="bold", **options)


def _trail_of(poses: Sequence[Pose | None], loaded: bool) -> tuple[list[float], list[float]]:
    """Return the points of the trail made ``loaded`` or not, with NaN at its gaps."""
    xs: list[float] = []
    ys: list[float] = []
    for before, after in pairwise(poses):
        if before is not None and after is not None and before.loaded == loaded:
            xs += [before.at[0], after.at[0]]
            ys += [before.at[1], after.at[1]]
        elif xs and not math.isnan(xs[-1]):
            xs.append(math.nan)
            ys.append(math.nan)
    return xs, ys
