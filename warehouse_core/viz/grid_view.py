"""The warehouse: tiles, robots, planned ways and hits."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from warehouse_core.render.palette import HIT, INK
from warehouse_core.viz.axes import draw_grid
from warehouse_core.viz.axes.tiles import draw_tiles, outer_of
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.fleet_view import FleetView
from warehouse_core.viz.robot_view import ABOVE_TILES, RobotView
from warehouse_core.viz.tracks.track import Frame, Hit, Point, Rows, Track
from warehouse_core.world.tiles import WALL

ROUTE_STYLE: tuple[float, tuple[float, ...]] = (0, (1.0, 1.6))
"""Dots, because a trail is a line or dashes."""

MAX_LINED_COLUMNS = 40
"""Wider grids have no lines between cells."""

LABEL_CELLS = 1.2
"""A label of a hit that is closer to the left or right end of the grid is moved inside."""


class GridView:
    """Draws the grid of a track into its axes, in units of cells, row 0 on top.

    Args:
        figure: to add the movers to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
        track: with at least one frame.
    """

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, track: Track) -> None:
        self._axes = axes
        self._figure = figure
        self._cell_points = cell_points
        self._slippery = track.slippery
        self._route: Line2D | None = None
        self._tiles: list[Artist] = []
        self._rows: Rows = ()
        first = track.frames[0]
        rows, fleet = first.tiles, first.fleet
        height, width = len(rows), len(rows[0])
        largest = max(height, width)
        every = 1 if largest <= 20 else 5 if largest <= 60 else 10
        lines = 0.6 if width <= MAX_LINED_COLUMNS else 0.0
        draw_grid(axes, (height, width), every, line_width=lines)
        outer = outer_of_track(track)
        axes.set(xlim=(outer, width - outer), ylim=(height - outer, outer), aspect="equal")
        axes.xaxis.tick_top()
        self.robots = [
            RobotView(figure, axes, cell_points, robot, track)
            for robot in range(0 if fleet else len(first.robots))
        ]
        self._fleet: FleetView | None = None
        if fleet:
            self._fleet = FleetView(figure, axes, cell_points, len(fleet.battery))
        self._hits = axes.plot(
            [], [], "*", color=HIT, markeredgecolor=INK, markeredgewidth=0.5 if fleet else 1.0,
            markersize=0.4 * cell_points if fleet else max(9.0, 0.5 * cell_points),
            zorder=ABOVE_TILES + 1, clip_on=False,
        )[0]  # fmt: skip
        self._hit_label = axes.text(
            0, 0, "", fontsize=10, fontweight="bold", color=INK, va="bottom",
            bbox={"boxstyle": "round,pad=0.2", "facecolor": HIT, "linewidth": 0},
            zorder=ABOVE_TILES + 1,
        )  # fmt: skip
        for mover in (self._hits, self._hit_label):
            figure.add_mover(mover)
        self.show_tiles(rows)

    def show_tiles(self, rows: Rows) -> None:
        """Draw these tiles, unless they are drawn already."""
        if rows is self._rows:
            return
        for artist in self._tiles:
            artist.remove()
        self._rows = rows
        open_cells = [cell for cell in self._slippery if is_open(rows, cell)]
        self._tiles = draw_tiles(self._axes, rows, self._cell_points, open_cells)

    def show_robots(self, frames: Sequence[Frame], number: int) -> None:
        """Draw the robots where they are in a frame, and what they have left behind before."""
        if self._fleet:
            self._fleet.show(frames[number])
        for robot in self.robots:
            robot.show(frames, number)

    def show_hits(self, hits: Sequence[Hit]) -> None:
        """Mark the places of hits, and label the last of them."""
        self._hits.set_data([hit.at[0] for hit in hits], [hit.at[1] for hit in hits])
        label = hits[-1].label if hits else ""
        self._hit_label.set_visible(bool(label))
        if label:
            (x, y), width = hits[-1].at, len(self._rows[0])
            side = "left" if x < LABEL_CELLS else "right" if x > width - LABEL_CELLS else "center"
            place = (min(max(x, 0.1), width - 0.1), max(y - 0.25, 0.5))
            self._hit_label.set(text=label, position=place, ha=side)

    def show_route(self, points: Sequence[Point]) -> None:
        """Draw a planned way as dots."""
        if self._route is None:
            if not points:
                return
            width = max(1.8, self._cell_points / 14)
            self._route = self._axes.add_line(
                Line2D([], [], color=INK, linestyle=ROUTE_STYLE, linewidth=width, zorder=1.9)
            )
            self._figure.add_mover(self._route)
        self._route.set_data([x for x, _ in points], [y for _, y in points])


def outer_of_track(track: Track) -> float:
    """Return how much of the outermost cells of a track is not shown, in cells."""
    return outer_of({frame.tiles for frame in track.frames})


def shown_size(track: Track) -> tuple[float, float]:
    """Return the width and height of what is shown of the map of a track, in cells."""
    rows, outer = track.frames[0].tiles, outer_of_track(track)
    return len(rows[0]) - 2 * outer, len(rows) - 2 * outer


def is_open(rows: Rows, cell: tuple[int, int]) -> bool:
    """Return whether a cell is among the tiles, and not a wall."""
    row, col = cell
    return 0 <= row < len(rows) and 0 <= col < len(rows[0]) and rows[row][col] != WALL
