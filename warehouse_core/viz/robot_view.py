"""One robot in a picture: its disc, nose and letter, its item, its trail, and what it sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, PathPatch, Polygon
from numpy.typing import NDArray

from warehouse_core.render.palette import (
    COLORS,
    INK,
    ITEM,
    PAPER,
    SEEN,
    TRAIL_COLORS,
    TRAIL_STYLES,
    VISITED,
    faded_trail,
)
from warehouse_core.viz.axes.glyphs import letter_path
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.track import Frame, Point, Pose, Rows, Track
from warehouse_core.world.tiles import EMPTY, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, Cell

ROBOT_RADIUS = 0.31
"""In cells; the letter in the corner of a tile stays readable."""

MIN_ROBOT_POINTS, MIN_LETTER_POINTS = 5.0, 6.0
"""Minimum radius of a robot and size of its letter, for large grids with small cells."""

ABOVE_TILES = 3
"""Drawing order in an SVG; pixels are drawn in the order of the movers."""

TRAIL_STEPS = 60
"""Steps after which a trail has faded."""

FRAMES_APART = 3
"""Of the points of a trail inside a continuous motion."""

BOX, STATION_BOX, MIN_BOX_POINTS = 0.56, (0.73, 0.73), 2.0
"""Half a side of an item as a share of the radius of a robot, and where one is in its station."""

TIP = 1.5
"""Of the nose of a robot, from its middle, in radii."""

SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
_CELL = np.array([(0.02, 0.02), (0.98, 0.02), (0.98, 0.98), (0.02, 0.98)])

WEAK_MOTOR = (0.0, (1.4, 1.0))
"""Dashes of the outline of a robot with weak motors."""


class History:
    """Where a robot was after each step, and what became of items.

    Attributes:
        frames: the number of the frame at the end of each step.
        cells: where it was then.
        taken: the frames in which it had just taken an item.
        delivered: the frames in which it had just put one down, and where.
        starts_loaded: whether it has an item in the first frame.
    """

    def __init__(self, robot: int) -> None:
        self._robot, self._read = robot, 0
        self.frames: list[int] = []
        self.cells: list[Cell | None] = []
        self.taken: list[int] = []
        self.delivered: list[tuple[int, Cell]] = []
        self._was_loaded: bool | None = None
        self.starts_loaded = False

    def read(self, frames: Sequence[Frame]) -> None:
        """Read the frames that have not been read yet."""
        for number in range(self._read, len(frames)):
            pose = frames[number].robots[self._robot]
            cell = None if pose is None else (int(pose.at[1]), int(pose.at[0]))
            if frames[number].progress.is_integer():
                self.frames.append(number)
                self.cells.append(cell)
            if pose is None or cell is None:
                continue
            if self._was_loaded is None:
                self.starts_loaded = pose.loaded
            elif pose.loaded and not self._was_loaded:
                self.taken.append(number)
            elif self._was_loaded and not pose.loaded:
                self.delivered.append((number, cell))
            self._was_loaded = pose.loaded
        self._read = max(self._read, len(frames))

    def visits(self, step: int) -> dict[Cell, int]:
        """Return how often the robot came to each cell in the first steps."""
        visits: dict[Cell, int] = {}
        before: Cell | None = None
        for cell in self.cells[: step + 1]:
            if cell is not None and cell != before:
                visits[cell] = visits.get(cell, 0) + 1
            before = cell
        return visits


class RobotView:
    """Draws a robot into axes whose unit is a cell.

    Args:
        figure: to add the movers to.
        axes: to draw into.
        cell_points: side of a cell in points, 1/72 inch.
        robot: its index.
        track: whose view radius, slippery cells and motor strength are shown.
    """

    def __init__(
        self,
        figure: SceneFigure,
        axes: Axes,
        cell_points: float,
        robot: int,
        track: Track,
    ) -> None:
        self._robot, self._slippery = robot, {*track.slippery}
        self._view_radius = track.view_radius if len(track.frames[0].robots) == 1 else None
        self._history = History(robot)
        self._radius = radius = max(ROBOT_RADIUS, MIN_ROBOT_POINTS / cell_points)
        self._box = max(BOX * ROBOT_RADIUS, MIN_BOX_POINTS / cell_points)
        thin, zorder = max(0.6, cell_points / 20), ABOVE_TILES
        self._floor = PolyCollection([], linewidths=0, zorder=0.6)
        self._trails = {
            loaded: LineCollection(
                [], linestyles=[style], linewidths=max(1.0, cell_points / 11), zorder=2.0
            )
            for loaded, style in TRAIL_STYLES.items()
        }
        self._leg = Line2D([], [], linewidth=max(1.0, cell_points / 11), zorder=2.0)
        self._settled: tuple[Rows, int] | None = None
        self._disc = Circle((0, 0), radius, linewidth=1.4 * thin, edgecolor=INK, zorder=zorder)
        if track.motor_strength < 1:
            self._disc.set_linestyle(WEAK_MOTOR)
        self._nose = Polygon(
            np.zeros((3, 2)),
            facecolor=INK,
            edgecolor=PAPER,
            linewidth=thin / 2,
            zorder=zorder - 0.1,
        )
        self._items = PolyCollection(
            [], facecolors=[ITEM], edgecolors=[INK], linewidths=thin, zorder=zorder
        )
        size = max(0.42, MIN_LETTER_POINTS / cell_points)
        self._paths = {True: letter_path(ROBOT_LOADED, 0.95 * size),
                       False: letter_path(ROBOT_EMPTY, size)}  # fmt: skip
        self._letter = PathPatch(self._paths[False], linewidth=0, zorder=zorder)
        for collection in (self._floor, *self._trails.values()):
            axes.add_collection(collection, autolim=False)
        axes.add_line(self._leg)
        axes.add_patch(self._nose)
        axes.add_patch(self._disc)
        axes.add_collection(self._items, autolim=False)
        axes.add_patch(self._letter)
        for mover in (
            self._floor, *self._trails.values(), self._leg, self._nose, self._disc, self._items,
            self._letter,
        ):  # fmt: skip
            figure.add_mover(mover)

    def show(self, frames: Sequence[Frame], number: int) -> None:
        """Draw the robot as it is in a frame, and what it has left behind before."""
        frame = frames[number]
        pose = frame.robots[self._robot]
        history = self._history
        history.read(frames)
        step = math.floor(frame.progress)
        if self._settled != (frame.tiles, step):
            self._show_floor(frame.tiles, step)
            self._show_trail(frames, step)
            self._settled = frame.tiles, step
        self._show_leg(frames, history.frames[step], number)
        self._show_items(frame.tiles, pose, number)
        for artist in (self._disc, self._nose, self._letter):
            artist.set_visible(pose is not None)
        if pose is None:
            return
        kind = ROBOT_LOADED if pose.loaded else ROBOT_EMPTY
        self._disc.set(center=pose.at, facecolor=COLORS[kind])
        path = self._paths[pose.loaded]
        moved = path.vertices + np.array(pose.at)
        self._letter.set_path(type(path)(moved, path.codes))
        self._letter.set_facecolor(INK if pose.loaded else PAPER)
        self._nose.set_visible(pose.heading is not None)
        if pose.heading is not None:
            self._nose.set_xy(nose_of(pose, self._radius))

    def _show_floor(self, rows: Rows, step: int) -> None:
        """Tint the floor that the robot sees, and where it came more than once."""
        colors: dict[Cell, Any] = {}
        here = self._history.cells[step]
        if here is not None and self._view_radius is not None:
            (row, col), radius = here, self._view_radius
            for line in range(max(0, row - radius), min(len(rows), row + radius + 1)):
                for place in range(max(0, col - radius), min(len(rows[0]), col + radius + 1)):
                    colors[line, place] = SEEN
        for cell, visits in self._history.visits(step).items():
            if visits > 1:
                colors[cell] = VISITED[min(visits // 2, len(VISITED)) - 1]
        shown = [
            (row, col)
            for row, col in colors
            if rows[row][col] == EMPTY and (row, col) not in self._slippery
        ]
        self._floor.set_verts([_CELL + np.array((col, row)) for row, col in shown])
        self._floor.set_facecolor([colors[cell] for cell in shown])

    def _show_trail(self, frames: Sequence[Frame], step: int) -> None:
        """Draw the way in the last complete steps, in pieces of one age and load."""
        ends = self._history.frames
        pieces: list[tuple[bool, Any, list[Point]]] = []
        recent = ends[max(0, step - TRAIL_STEPS) : step + 1]
        numbers = [n for first, end in pairwise(recent) for n in range(first, end, FRAMES_APART)]
        for before, after in pairwise([*numbers, recent[-1]]):
            start, end = frames[before].robots[self._robot], frames[after].robots[self._robot]
            if start is None or end is None:
                continue
            age = min((step - frames[before].progress) / TRAIL_STEPS, 0.999)
            look = start.loaded, faded_trail(start.loaded, age)
            if not pieces or pieces[-1][:2] != look or pieces[-1][2][-1] != start.at:
                pieces.append((*look, [start.at]))
            pieces[-1][2].append(end.at)
        for loaded, trail in self._trails.items():
            trail.set_segments([way for kind, _, way in pieces if kind == loaded])
            trail.set_color([color for kind, color, _ in pieces if kind == loaded])

    def _show_leg(self, frames: Sequence[Frame], first: int, last: int) -> None:
        """Draw the way in the step that is not complete."""
        poses = [frame.robots[self._robot] for frame in frames[first : last + 1]]
        points = [pose.at for pose in poses if pose is not None]
        loaded = bool(poses[0] and poses[0].loaded)
        self._leg.set_data([x for x, _ in points], [y for _, y in points])
        self._leg.set(color=TRAIL_COLORS[loaded], linestyle=TRAIL_STYLES[loaded])

    def _show_items(self, rows: Rows, pose: Pose | None, number: int) -> None:
        """Draw the items that wait at pickups, that on the robot, and what it has delivered."""
        history = self._history
        at_rest = {cell for frame, cell in history.delivered if frame <= number}
        if not history.starts_loaded and not any(frame <= number for frame in history.taken):
            at_rest |= {
                (row, col)
                for row, line in enumerate(rows)
                for col, tile in enumerate(line)
                if tile == PICKUP
            }
        places = [np.array((col, row)) + STATION_BOX for row, col in sorted(at_rest)]
        boxes = [self._box * SQUARE + place for place in places]
        if pose is not None and pose.loaded:
            boxes.append(BOX * self._radius * SQUARE + np.array(pose.at))
        self._items.set_verts(boxes)


def nose_of(pose: Pose, radius: float, tip: float = TIP) -> NDArray[np.float64]:
    """Return the corners, in cells, of the wedge that shows where a robot heads.

    Args:
        pose: with a heading.
        radius: of the robot, in cells.
        tip: see ``TIP``.
    """
    heading = pose.heading or 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    wedge = np.array([(0.72, -0.62), (tip, 0.0), (0.72, 0.62)])
    turned = wedge @ np.array([(cos, sin), (-sin, cos)])
    corners: NDArray[np.float64] = radius * turned + np.array(pose.at)
    return corners
