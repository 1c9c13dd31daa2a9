"""The warehouse itself: tiles, the robots over them, and what they hit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import COLORS, FAINT, HIT, INK, UNKNOWN, UNKNOWN_STRIPE
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.robot_view import RobotView, letter
from warehouse_core.viz.track import Hit, Point, Rows
from warehouse_core.world.tiles import DROPOFF, EMPTY, PICKUP, WALL, runs_of

ROUTE_STYLE: tuple[float, tuple[float, ...]] = (0, (1.0, 1.6))
"""Dots: a trail is a line or dashes."""


class GridView:
    """Draws the grid of a track into its axes, in units of cells, row 0 on top.

    Args:
        figure: that the movers are added to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch, which the letters are scaled by.
        rows: the tiles to begin with.
        robots: how many there are to draw.
    """

    def __init__(
        self, figure: SceneFigure, axes: Axes, cell_points: float, rows: Rows, robots: int = 1
    ) -> None:
        self._axes = axes
        self._figure = figure
        self._cell_points = cell_points
        self._route: Line2D | None = None
        self._tiles: list[Artist] = []
        self._rows: Rows = ()
        self._prepare_axes(len(rows), len(rows[0]))
        self.robots = [RobotView(figure, axes, cell_points) for _ in range(robots)]
        self._hits = axes.plot(
            [], [], "*", color=HIT, markeredgecolor=INK, markersize=max(9.0, 0.5 * cell_points)
        )[0]
        self._hit_label = axes.text(
            0, 0, "", fontsize=8, fontweight="bold", color=INK, ha="center", va="bottom",
            bbox={"boxstyle": "round,pad=0.2", "facecolor": HIT, "linewidth": 0},
        )  # fmt: skip
        for mover in (self._hits, self._hit_label):
            figure.add_mover(mover)
        self.show_tiles(rows)

    def show_tiles(self, rows: Rows) -> None:
        """Draw these tiles, unless they are the ones that stand there already."""
        if rows is self._rows:
            return
        for artist in self._tiles:
            artist.remove()
        self._rows = rows
        self._tiles = [
            self._rectangles(rows, WALL, inset=0.0),
            self._rectangles(rows, PICKUP, inset=0.06),
            self._rectangles(rows, DROPOFF, inset=0.06),
            *self._letters(rows),
            *self._unseen(rows),
        ]

    def show_hits(self, hits: Sequence[Hit]) -> None:
        """Flash where the robot hit something."""
        self._hits.set_data([hit.at[0] for hit in hits], [hit.at[1] for hit in hits])
        label = hits[-1].label if hits else ""
        self._hit_label.set_visible(bool(label))
        if label:
            self._hit_label.set(text=label, position=(hits[-1].at[0], hits[-1].at[1] - 0.25))

    def show_route(self, points: Sequence[Point]) -> None:
        """Draw the way that the robot means to go, as dots."""
        if self._route is None:
            width = max(1.8, self._cell_points / 14)
            self._route = self._axes.add_line(
                Line2D([], [], color=INK, linestyle=ROUTE_STYLE, linewidth=width, zorder=1.9)
            )
            self._figure.add_mover(self._route)
        self._route.set_data([x for x, _ in points], [y for _, y in points])

    def _prepare_axes(self, height: int, width: int) -> None:
        axes = self._axes
        axes.set(xlim=(0, width), ylim=(height, 0), aspect="equal", facecolor=COLORS[EMPTY])
        axes.spines[:].set_visible(False)
        lines = [((x, 0), (x, height)) for x in range(width + 1)]
        lines += [((0, y), (width, y)) for y in range(height + 1)]
        axes.add_collection(LineCollection(lines, colors=[FAINT], linewidths=0.6, zorder=0.5))
        every = 1 if max(height, width) <= 20 else 5 if max(height, width) <= 60 else 10
        axes.set_xticks([c + 0.5 for c in range(0, width, every)], map(str, range(0, width, every)))
        axes.set_yticks(
            [r + 0.5 for r in range(0, height, every)], map(str, range(0, height, every))
        )
        axes.tick_params(length=0, labelsize=7, labelcolor="0.45", pad=1)
        axes.xaxis.tick_top()

    def _rectangles(self, rows: Rows, tile: str, inset: float) -> PatchCollection:
        # Walls are drawn run by run, stations cell by cell.
        def spans(line: str) -> list[tuple[int, int]]:
            runs = list(runs_of(tile, line))
            return runs if tile == WALL else [(c, c + 1) for run in runs for c in range(*run)]

        rectangles = [
            Rectangle((left + inset, row + inset), right - left - 2 * inset, 1 - 2 * inset)
            for row, line in enumerate(rows)
            for left, right in spans(line)
        ]
        color = COLORS[tile]
        # A hair of an edge and no smoothing let the walls of neighbouring rows meet with no seam.
        seam = 0.4 if tile == WALL else 0.0
        patches = PatchCollection(
            rectangles,
            facecolor=color,
            edgecolor=color,
            linewidth=seam,
            antialiased=False,
            zorder=1,
        )
        self._axes.add_collection(patches)
        return patches

    def _unseen(self, rows: Rows) -> Iterator[PatchCollection]:
        """Yield stripes over what nobody has seen, if there is any."""
        rectangles = [
            Rectangle((left, row), right - left, 1)
            for row, line in enumerate(rows)
            for left, right in runs_of(UNSEEN, line)
        ]
        if rectangles:
            patches = PatchCollection(
                rectangles, facecolor=UNKNOWN, edgecolor=UNKNOWN_STRIPE, linewidth=0,
                hatch="///", antialiased=False, zorder=1,
            )  # fmt: skip
            self._axes.add_collection(patches)
            yield patches

    def _letters(self, rows: Rows) -> Iterator[Text]:
        for row, line in enumerate(rows):
            for col, tile in enumerate(line):
                if tile in (PICKUP, DROPOFF):
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
