"""The warehouse: tiles, robots, planned ways and hits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import COLORS, HIT, INK, UNKNOWN, UNKNOWN_STRIPE
from warehouse_core.viz.axes import draw_grid
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.fleet_view import FleetView
from warehouse_core.viz.robot_view import ABOVE_TILES, RobotView, letter
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Hit, Point, Rows, has_chargers
from warehouse_core.world.tiles import CHARGER, DROPOFF, PICKUP, WALL, runs_of

ROUTE_STYLE: tuple[float, tuple[float, ...]] = (0, (1.0, 1.6))
"""Dots, because a trail is a line or dashes."""


class GridView:
    """Draws the grid of a track into its axes, in units of cells, row 0 on top.

    Args:
        figure: to add the movers to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
        rows: the tiles of the first frame.
        robots: their number.
        fleet: what the first frame shows of a fleet, if the robots are those of one.
    """

    def __init__(
        self,
        figure: SceneFigure,
        axes: Axes,
        cell_points: float,
        rows: Rows,
        robots: int,
        fleet: FleetFrame | None = None,
    ) -> None:
        self._axes = axes
        self._figure = figure
        self._cell_points = cell_points
        self._route: Line2D | None = None
        self._tiles: list[Artist] = []
        self._rows: Rows = ()
        largest = max(len(rows), len(rows[0]))
        every = 1 if largest <= 20 else 5 if largest <= 60 else 10
        draw_grid(axes, (len(rows), len(rows[0])), every, line_width=0.6)
        axes.set_aspect("equal")
        axes.xaxis.tick_top()
        self.robots = [RobotView(figure, axes, cell_points) for _ in range(0 if fleet else robots)]
        self._fleet: FleetView | None = None
        if fleet:
            self._fleet = FleetView(figure, axes, cell_points, len(fleet.battery))
        self._hits = axes.plot(
            [], [], "*", color=HIT, markeredgecolor=INK, markeredgewidth=0.5 if fleet else 1.0,
            markersize=0.4 * cell_points if fleet else max(9.0, 0.5 * cell_points),
            zorder=ABOVE_TILES + 1 if fleet else 2,
        )[0]  # fmt: skip
        self._hit_label = axes.text(
            0, 0, "", fontsize=8, fontweight="bold", color=INK, ha="center", va="bottom",
            bbox={"boxstyle": "round,pad=0.2", "facecolor": HIT, "linewidth": 0},
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
        # A thin edge without antialiasing leaves no seam between the walls of two rows.
        self._tiles = [self._draw(rows, WALL, 0.0, color=COLORS[WALL], linewidth=0.4)]
        for tile in (PICKUP, DROPOFF, *has_chargers(rows) * CHARGER):
            self._tiles.append(self._draw(rows, tile, 0.06, color=COLORS[tile], linewidth=0.0))
        self._tiles += self._letters(rows)
        if any(UNSEEN in line for line in rows):
            stripes = {"edgecolor": UNKNOWN_STRIPE, "linewidth": 0, "hatch": "///"}
            self._tiles.append(self._draw(rows, UNSEEN, 0.0, facecolor=UNKNOWN, **stripes))

    def show_robots(self, frames: Sequence[Frame]) -> None:
        """Draw the robots where they are in the last of these frames, and their trails there."""
        if self._fleet:
            self._fleet.show(frames[-1])
            return
        ways = zip(*(frame.robots for frame in frames), strict=True)
        for robot, poses in zip(self.robots, ways, strict=True):
            robot.show(poses)

    def show_hits(self, hits: Sequence[Hit]) -> None:
        """Mark the places of hits, and label the last of them."""
        self._hits.set_data([hit.at[0] for hit in hits], [hit.at[1] for hit in hits])
        label = hits[-1].label if hits else ""
        self._hit_label.set_visible(bool(label))
        if label:
            self._hit_label.set(text=label, position=(hits[-1].at[0], hits[-1].at[1] - 0.25))

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

    def _draw(self, rows: Rows, tile: str, inset: float, **style: Any) -> Artist:
        """Draw the runs of a tile, or each of its cells with an inset."""
        runs = [(row, *run) for row, line in enumerate(rows) for run in runs_of(tile, line)]
        if inset:
            runs = [(row, col, col + 1) for row, *run in runs for col in range(*run)]
        rectangles = [
            Rectangle((left + inset, row + inset), right - left - 2 * inset, 1 - 2 * inset)
            for row, left, right in runs
        ]
        patches = PatchCollection(rectangles, antialiased=False, zorder=1, **style)
        return self._axes.add_collection(patches)

    def _letters(self, rows: Rows) -> Iterator[Text]:
        for row, line in enumerate(rows):
            for col, tile in enumerate(line):
                if tile in (PICKUP, DROPOFF, CHARGER):
                    yield letter(
                        self._axes,
                        self._cell_points,
                        col + 0.09,
                        row + 0.08,
                        tile,
                        0.24,
                        color=INK,
                        ha="left",
                        va="top",
                        zorder=2,
                    )
