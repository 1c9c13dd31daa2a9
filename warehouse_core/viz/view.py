"""The warehouse in axes whose unit is a cell: tiles, robots, planned ways and hits.

A robot on its own has a letter, a trail and the items of its episode; robots of a fleet have
numbers, batteries and orders. Artists are drawn in the order in which they are added.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PathCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, PathPatch, Polygon
from matplotlib.text import Text
from matplotlib.transforms import AffineDeltaTransform
from numpy.typing import NDArray

from warehouse_core.render.palette import (
    BATTERY,
    COLORS,
    HIT,
    INK,
    ITEM,
    ORDER_COLORS,
    PAPER,
    SHADOW,
    STRANDED,
    TRAIL_COLORS,
    TRAIL_STYLES,
    VISITED,
    WARNING,
    Color,
    faded_trail,
)
from warehouse_core.viz.axes import draw_grid
from warehouse_core.viz.axes.glyphs import letter_path
from warehouse_core.viz.axes.plans import PlanView
from warehouse_core.viz.axes.tiles import BAND, TileBounds, cells_of, draw_tiles
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import (
    DrawnHit,
    FleetFrame,
    Frame,
    Point,
    Pose,
    TileRows,
    Track,
    Waiting,
)
from warehouse_core.world.tiles import EMPTY, PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, WALL, Cell

ABOVE_TILES = 3
"""Drawing order of robots in an SVG; pixels are drawn in the order of the movers."""

ROUTE_STYLE: tuple[float, tuple[float, ...]] = (0, (1.0, 1.6))
"""Dots, because a trail is a line or dashes."""

MAX_LINED_COLUMNS = 40
"""Columns of the widest grid that has lines between its cells."""

LABEL_CELLS = 1.2
"""Distance to the left or right end of the grid at which the label of a hit is moved inside."""

ROBOT_RADIUS, MIN_ROBOT_POINTS, MIN_LETTER_POINTS = 0.31, 5.0, 6.0
"""Radius of a robot in cells, which leaves the letter of a tile readable; least radius, and least
size of its letter, in points."""

TRAIL_STEPS = 60
"""Steps after which a trail has faded."""

FRAMES_APART = 3
"""Frames of a continuous motion between two points of a trail."""

ITEM_SHARE, STATION_PLACE, MIN_ITEM_POINTS = 0.56, (0.73, 0.73), 2.0
"""Half a side of an item as a share of the radius of a robot; place of an item in the cell of its
station; least half side in points."""

WEAK_MOTOR = (0.0, (1.4, 1.0))
"""Dashes around a robot with weak motors."""

FLEET_RADIUS, MAX_RADIUS, GOOD_POINTS, MIN_POINTS = 0.36, 0.45, 9.0, 2.5
"""Radius of a robot of a fleet in cells; it grows up to ``MAX_RADIUS`` where it has fewer than
``GOOD_POINTS``, and is never below ``MIN_POINTS``."""

MIN_NUMBER_POINTS, MIN_BOX_POINTS, DIGIT = 5.0, 7.0, 0.7
"""Least sizes of the numbers of robots and of orders; width of a digit as a share of its size."""

WAITING_AT = 0.26, 0.3
"""Place of the number of orders at a pickup, from the middle of its cell: beside its letter."""

NUMBER_BOX: dict[str, Any] = {"boxstyle": "square,pad=0.12", "linewidth": 0.8}
"""Style of the box around the number of orders at a pickup."""

FEW = 12
"""Robots of the largest fleet that always shows all batteries; larger ones show low batteries."""

LOW_BATTERY = 0.25
"""Share of a full battery below which a robot of a fleet shows a warning."""

LATE = len(ORDER_COLORS) - 1

TIP, FLEET_TIP = 1.5, 1.38
"""Distance of the tip of a nose from the middle of a robot, in radii; in a fleet the nose stays in
its cell."""

SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
DIAMOND = np.array([(0, -1), (1, 0), (0, 1), (-1, 0)])
UNIT = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
TINTED = np.array([(0.02, 0.02), (0.98, 0.02), (0.98, 0.98), (0.02, 0.98)])


class View:
    """Draws the map of a track into its axes, row 0 on top; a cell has ``cell_points`` points."""

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, track: Track) -> None:
        self._figure, self._axes, self._cell_points = figure, axes, cell_points
        self._slippery = track.slippery
        self._route: Line2D | None = None
        self._tiles: list[Artist] = []
        self._rows: TileRows = ()
        first = track.frames[0]
        rows, fleet = first.tiles, first.fleet
        height, width = len(rows), len(rows[0])
        largest = max(height, width)
        every = 1 if largest <= 20 else 5 if largest <= 60 else 10
        lines = 0.6 if width <= MAX_LINED_COLUMNS else 0.0
        draw_grid(axes, (height, width), every, line_width=lines)
        outer = track.outer
        axes.set(xlim=(outer, width - outer), ylim=(height - outer, outer), aspect="equal")
        axes.xaxis.tick_top()
        self._robots: list[RobotView] | list[FleetView]
        if fleet:
            self._robots = [FleetView(figure, axes, cell_points, len(fleet.battery))]
            star: dict[str, Any] = {"markersize": 0.4 * cell_points, "markeredgewidth": 0.5}
        else:
            self._robots = [
                RobotView(figure, axes, cell_points, robot, track)
                for robot in range(len(first.robots))
            ]
            star = {"markersize": max(9.0, 0.5 * cell_points), "markeredgewidth": 1.0}
        above: dict[str, Any] = {"zorder": ABOVE_TILES + 1}
        star |= above | {"color": HIT, "markeredgecolor": INK, "clip_on": False}
        self._hits = axes.plot([], [], "*", **star)[0]
        self._hit_label = axes.text(
            0, 0, "", fontsize=10, fontweight="bold", color=INK, va="bottom",
            bbox={"boxstyle": "round,pad=0.2", "facecolor": HIT, "linewidth": 0}, **above,
        )  # fmt: skip
        figure.add_mover(self._hits)
        figure.add_mover(self._hit_label)
        self._show_tiles(rows)

    def show(self, frames: Sequence[Frame], number: int) -> None:
        """Draw a frame, and what robots have left behind before it."""
        frame = frames[number]
        self._show_tiles(frame.tiles)
        for robots in self._robots:
            robots.show(frames, number)
        self._show_route(frame.route)
        self.show_hits(frame.hits)

    def show_hits(self, hits: Sequence[DrawnHit]) -> None:
        """Mark the places of hits, and label the last of them."""
        self._hits.set_data([hit.at[0] for hit in hits], [hit.at[1] for hit in hits])
        label = hits[-1].label if hits else ""
        self._hit_label.set_visible(bool(label))
        if label:
            (x, y), width = hits[-1].at, len(self._rows[0])
            side = "left" if x < LABEL_CELLS else "right" if x > width - LABEL_CELLS else "center"
            place = (min(max(x, 0.1), width - 0.1), max(y - 0.25, 0.5))
            self._hit_label.set(text=label, position=place, ha=side)

    def _show_tiles(self, rows: TileRows) -> None:
        """Draw these tiles, unless they are drawn already."""
        if rows is self._rows:
            return
        for artist in self._tiles:
            artist.remove()
        self._rows = rows
        open_cells = [cell for cell in self._slippery if is_open(rows, cell)]
        self._tiles = draw_tiles(self._axes, rows, self._cell_points, open_cells)

    def _show_route(self, points: Sequence[Point]) -> None:
        """Draw a planned way as dots."""
        if self._route is None:
            if not points:
                return
            width = max(1.8, self._cell_points / 14)
            self._route = Line2D(
                [], [], color=INK, linestyle=ROUTE_STYLE, linewidth=width, zorder=1.9
            )
            self._figure.add_movers(self._axes, self._route)
        self._route.set_data([x for x, _ in points], [y for _, y in points])


class RobotView:
    """Draws one robot of a track: disc, nose and letter, items, trail, and what it sees."""

    def __init__(
        self, figure: SceneFigure, axes: Axes, cell_points: float, robot: int, track: Track
    ) -> None:
        self._robot, self._slippery = robot, {*track.slippery}
        self._view_radius = track.view_radius if len(track.frames[0].robots) == 1 else None
        rows = track.frames[0].tiles
        outer = 1 - BAND if track.outer else 0.0
        self._shown = outer, outer, len(rows[0]) - outer, len(rows) - outer
        self._history = History(robot)
        self._radius = radius = max(ROBOT_RADIUS, MIN_ROBOT_POINTS / cell_points)
        self._half_item = max(ITEM_SHARE * ROBOT_RADIUS, MIN_ITEM_POINTS / cell_points)
        self._settled: tuple[TileRows, int] | None = None
        thin, wide = max(0.6, cell_points / 20), max(1.0, cell_points / 11)
        above: dict[str, Any] = {"zorder": ABOVE_TILES}
        self._floor = PolyCollection([], linewidths=0, zorder=0.6)
        self._shadow = PolyCollection(
            [], facecolors=[INK], alpha=SHADOW, linewidths=0, antialiased=False, zorder=2.5
        )
        self._trails = {
            loaded: LineCollection([], linestyles=[style], linewidths=wide, zorder=2.0)
            for loaded, style in TRAIL_STYLES.items()
        }
        self._leg = Line2D([], [], linewidth=wide, zorder=2.0)
        self._disc = Circle((0, 0), radius, linewidth=1.4 * thin, edgecolor=INK, **above)
        if track.motor_strength < 1:
            self._disc.set_linestyle(WEAK_MOTOR)
        self._nose = Polygon(
            np.zeros((3, 2)), facecolor=INK, edgecolor=PAPER, linewidth=thin / 2,
            zorder=ABOVE_TILES - 0.1,
        )  # fmt: skip
        self._items = PolyCollection(
            [], facecolors=[ITEM], edgecolors=[INK], linewidths=thin, **above
        )
        size = max(0.42, MIN_LETTER_POINTS / cell_points)
        self._paths = {True: letter_path(ROBOT_LOADED, 0.95 * size),
                       False: letter_path(ROBOT_EMPTY, size)}  # fmt: skip
        self._letter = PathPatch(self._paths[False], linewidth=0, **above)
        figure.add_movers(
            axes, self._floor, self._shadow, *self._trails.values(), self._leg, self._nose,
            self._disc, self._items, self._letter,
        )  # fmt: skip

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
        self._disc.set(center=pose.at, facecolor=_color_of(pose))
        path = self._paths[pose.loaded]
        moved = path.vertices + np.array(pose.at)
        self._letter.set_path(type(path)(moved, path.codes))
        self._letter.set_facecolor(INK if pose.loaded else PAPER)
        self._nose.set_visible(pose.heading is not None)
        if pose.heading is not None:
            self._nose.set_xy(nose_of(pose, self._radius))

    def _show_floor(self, rows: TileRows, step: int) -> None:
        """Shade what the robot does not see, and tint where it came more than once."""
        here = self._history.cells[step]
        if here is not None and self._view_radius is not None:
            self._shadow.set_verts(boxes_around(here, self._view_radius, self._shown))
        colors: dict[Cell, Any] = {}
        for cell, visits in self._history.visits(step).items():
            if visits > 1:
                colors[cell] = VISITED[min(visits // 2, len(VISITED)) - 1]
        shown = [
            (row, col)
            for row, col in colors
            if rows[row][col] == EMPTY and (row, col) not in self._slippery
        ]
        self._floor.set_verts([TINTED + np.array((col, row)) for row, col in shown])
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

    def _show_items(self, rows: TileRows, pose: Pose | None, number: int) -> None:
        """Draw the items that wait at pickups, the one on the robot, and what was delivered."""
        history = self._history
        at_rest = {cell for frame, cell in history.delivered if frame <= number}
        if not history.starts_loaded and not any(frame <= number for frame in history.taken):
            at_rest.update(cells_of(PICKUP, rows))
        places = [np.array((col, row)) + STATION_PLACE for row, col in sorted(at_rest)]
        boxes = [self._half_item * SQUARE + place for place in places]
        if pose is not None and pose.loaded:
            boxes.append(ITEM_SHARE * self._radius * SQUARE + np.array(pose.at))
        self._items.set_verts(boxes)


def boxes_around(cell: Cell, radius: int, shown: TileBounds) -> list[NDArray[np.float64]]:
    """Return the four boxes that are shown around the square window of a view.

    Args:
        cell: cell in the middle of the window.
        radius: cells from there to its edge.
        shown: left, top, right and bottom of what is shown.
    """
    (row, col), (left, top, right, bottom) = cell, shown
    first, last = max(col - radius, left), min(col + radius + 1, right)
    upper, lower = max(row - radius, top), min(row + radius + 1, bottom)
    boxes = (
        (left, top, right, upper), (left, lower, right, bottom),
        (left, upper, first, lower), (last, upper, right, lower),
    )  # fmt: skip
    return [np.array([(x, y), (end, y), (end, low), (x, low)]) for x, y, end, low in boxes]


class FleetView:
    """Draws a fleet of ``robots`` with their numbers, items and batteries, people, and orders."""

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, robots: int) -> None:
        self._figure, self._axes, self._robots = figure, axes, robots
        self._cell_points = cell_points
        self._radius = radius = max(
            FLEET_RADIUS, min(MAX_RADIUS, GOOD_POINTS / cell_points), MIN_POINTS / cell_points
        )
        above: dict[str, Any] = {"zorder": ABOVE_TILES}
        thin = min(1.2, max(0.3, cell_points / 24))
        edge: dict[str, Any] = {"edgecolors": [INK], "linewidths": thin, **above}
        side = 2 * radius
        self._plans = PlanView(cell_points, ABOVE_TILES)
        self._people = PolyCollection([], facecolors=[COLORS[PERSON]], **edge)
        self._noses = PolyCollection([], facecolors=[INK], linewidths=0, **above)
        self._discs = EllipseCollection(
            [side], [side], [0], units="xy", offsets=[], offset_transform=axes.transData, **edge
        )
        size = min(0.5, 1.5 * radius / (DIGIT * len(str(robots - 1))))
        legible = robots if size * cell_points >= MIN_NUMBER_POINTS else 0
        # One collection is drawn faster than as many texts.
        by: Any = axes.transData  # affine, which its type does not say
        self._numbers = PathCollection(
            [letter_path(str(robot), size) for robot in range(legible)], offsets=[],
            offset_transform=by, transform=AffineDeltaTransform(by), linewidths=0, **above,
        )  # fmt: skip
        self._grounds = PolyCollection([], facecolors=[PAPER], **edge)
        self._levels = PolyCollection([], linewidths=0, **above)
        self._items = PolyCollection([], **edge)
        figure.add_movers(
            axes, self._plans.ways, self._plans.wishes, self._people, self._noses, self._discs,
            self._numbers, self._grounds, self._levels, self._items, self._plans.pushes,
        )  # fmt: skip
        self._waiting: list[Text] = []

    def show(self, frames: Sequence[Frame], number: int) -> None:
        """Draw the fleet of a frame."""
        frame = frames[number]
        fleet = frame.fleet
        assert fleet is not None, "only frames of fleets are shown"
        poses = [pose for pose in frame.robots if pose is not None]
        robots, people = poses[: self._robots], poses[self._robots :]
        places = np.array([pose.at for pose in robots])
        self._people.set_verts(
            [np.array(person.at) + 0.95 * self._radius * DIAMOND for person in people]
        )
        colors = [_color_of(pose, share) for pose, share in zip(robots, fleet.battery, strict=True)]
        self._discs.set_offsets(places)
        self._discs.set_facecolor(colors)
        self._plans.show(fleet.plans, places, colors)
        self._noses.set_verts(
            [nose_of(pose, self._radius, FLEET_TIP) for pose in robots if pose.heading is not None]
        )
        self._numbers.set_offsets(places)
        self._numbers.set_facecolor(
            [INK if color == COLORS[ROBOT_LOADED] else PAPER for color in colors]
        )
        self._show_batteries(places, fleet)
        self._show_items(places, fleet)
        self._show_waiting(fleet.waiting)

    def _show_batteries(self, places: Any, fleet: FleetFrame) -> None:
        """Draw a bar below each robot; in large fleets only below robots whose battery is low."""
        shown = [
            ((x - self._radius, y + 0.75 * self._radius), share)
            for (x, y), share in zip(places.tolist(), fleet.battery, strict=True)
            if self._robots <= FEW or share < LOW_BATTERY
        ]
        length, height = 2 * self._radius, 0.32 * self._radius
        self._grounds.set_verts([np.array(at) + UNIT * (length, height) for at, _ in shown])
        self._levels.set_verts(
            [np.array(at) + UNIT * (share * length, height) for at, share in shown]
        )
        self._levels.set_facecolor(
            [WARNING if share < LOW_BATTERY else BATTERY for _, share in shown]
        )

    def _show_items(self, places: Any, fleet: FleetFrame) -> None:
        """Draw what robots carry, in the colours of the ages of its orders."""
        items = [
            (place, age) for place, age in zip(places, fleet.items, strict=True) if age is not None
        ]
        corner = 0.78 * self._radius
        self._items.set_verts(
            [place + (corner, -corner) + 0.4 * self._radius * SQUARE for place, _ in items]
        )
        self._items.set_facecolor([ORDER_COLORS[age] for _, age in items])
        self._items.set_edgecolor([_ink_on(age) for _, age in items])

    def _show_waiting(self, waiting: tuple[Waiting, ...]) -> None:
        """Write the number of orders at each pickup into a box of the colour of their age."""
        size = max(MIN_BOX_POINTS, 0.3 * self._cell_points)
        while len(self._waiting) < len(waiting):
            text = self._axes.text(
                0, 0, "", fontsize=size, fontweight="bold", ha="center", va="center_baseline",
                zorder=ABOVE_TILES + 1,
            )  # fmt: skip
            self._figure.add_mover(text)
            self._waiting.append(text)
        for text in self._waiting[len(waiting) :]:
            text.set_visible(False)
        for text, orders in zip(self._waiting, waiting, strict=False):
            x, y = orders.at
            text.set(
                visible=True,
                position=(x + WAITING_AT[0], y + WAITING_AT[1]),
                text=f"{orders.number}{'!' * (orders.age == LATE)}",
                color=_ink_on(orders.age),
            )
            box = {"facecolor": ORDER_COLORS[orders.age], "edgecolor": text.get_color()}
            text.set_bbox(NUMBER_BOX | box)


def nose_of(pose: Pose, radius: float, tip: float = TIP) -> NDArray[np.float64]:
    """Return the corners, in cells, of the wedge that shows where a robot heads.

    The tip is so many times the ``radius``, which is in cells, away from the middle of the robot.
    """
    heading = pose.heading or 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    wedge = np.array([(0.72, -0.62), (tip, 0.0), (0.72, 0.62)])
    turned = wedge @ np.array([(cos, sin), (-sin, cos)])
    corners: NDArray[np.float64] = radius * turned + np.array(pose.at)
    return corners


def is_open(rows: TileRows, cell: Cell) -> bool:
    """Return whether a cell is among the tiles, and not a wall."""
    row, col = cell
    return 0 <= row < len(rows) and 0 <= col < len(rows[0]) and rows[row][col] != WALL


def _color_of(pose: Pose, share: float = 1.0) -> Color:
    """Return the colour of a robot with a share of a full battery."""
    if share <= 0:
        return STRANDED
    return COLORS[ROBOT_LOADED if pose.loaded else ROBOT_EMPTY]


def _ink_on(age: int) -> Color:
    """Return the colour of what is written on an order, and of the line around it."""
    return PAPER if age == LATE else INK
