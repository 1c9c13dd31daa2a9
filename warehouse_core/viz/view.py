"""The floor of a track, drawn with matplotlib: tiles as pixels, and shapes on top of them.

The unit of the axes is a cell. ``render`` paints the tiles. Robots, people, items, plans and hits
are shapes with the geometry of ``tiles.json``. A single robot has a letter, a trail and the items
of its episode; robots of a fleet have numbers, batteries and orders.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.path import Path
from PIL import Image

from warehouse_core.render.painter import MAX_TILE_PIXELS, codes_of, paint_once
from warehouse_core.render.palette import (
    COLORS,
    FADES,
    LATE,
    LOOK,
    ORDERS,
    SHADOW,
    SKID,
    TRAIL_COLORS,
    VISITED,
    blend,
    color_named,
    faded_trail,
)
from warehouse_core.viz.axes import draw_grid
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.shapes import (
    BAR,
    CIRCLE,
    DOTS,
    SQUARE,
    Points,
    Shape,
    Shapes,
    cell_of,
    glyphs,
    joined,
    lines,
    outlined,
    polygons,
    stamped,
    written,
)
from warehouse_core.viz.tracks.history import History, skids_of
from warehouse_core.viz.tracks.track import (
    FleetFrame,
    Frame,
    Point,
    Pose,
    TileRows,
    Track,
    arrow_tip,
    cells_of,
    middle,
)
from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    EMPTY,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    Cell,
)

RADIUS, RIM, LETTER, NAME = LOOK["robot"].values()
BATTERIES, ITEMS, CARRIED, WIDTHS = (LOOK[key] for key in ("battery", "item", "carried", "lines"))

MIN_RADIUS, MIN_FLEET_RADIUS, MIN_LINE, MIN_LETTER, MIN_NUMBER, MIN_STATION = 5, 2.5, 0.6, 6, 5, 6.5
"""Least sizes in points: radius of a single robot, radius of a robot of a fleet, width of lines,
size of letters, size of robot numbers, and side of stations."""

MIN_ITEM, MIN_ORDERS, MIN_HIT, MIN_FLEET_HIT, MIN_END, LABEL = 4, 7, 5, 3, 6.5, 10
"""Least sizes in points: items, numbers of orders at a pickup, hits, hits in a fleet, and ends of a
search; then the size of a label."""

MIN_BODY = 5.5
"""Radius of a body in points from which on it has a chassis; a smaller one is a disc."""

MAX_RADIUS, GOOD_RADIUS = 0.45, 9
"""Robots of a fleet whose radius is below ``GOOD_RADIUS``, in points, are enlarged to it, but to at
most ``MAX_RADIUS``, in cells."""

FRAMES_APART = 3
"""Number of frames of a continuous motion between two points of a trail."""

FADE_STEPS, MAX_FADE = 20, 0.75
"""Number of steps over which a plan fades, and the final share of the floor's colour in it."""

WEAK_MOTOR, DASHES, GHOST = (1.4, 1.0), (2.5, 1.5), (3.0, 2.0)
"""Dash patterns, in multiples of the line width: around a robot with weak motors, of the trail of a
loaded robot, and around a ghost."""

STAR, DIAMOND, NOSE, ARROW, HEAD = (
    np.array(LOOK["shapes"][key]) for key in ("hit", "H", "nose", "push", "arrow")
)
CHASSIS, FRONT, LAMP = (np.array(LOOK["shapes"][key]) for key in ("chassis", "front", "brake"))
DRIVES = {drive: list(map(np.array, parts)) for drive, parts in LOOK["drives"].items()}
STAR_RADIUS = float(np.abs(STAR).max())


class Tiles(Artist):
    """An artist that fills axes with the tiles of a floor, as pixels."""

    rows: TileRows = ()
    slippery: Sequence[Cell] = ()

    def show(self, rows: TileRows, slippery: Sequence[Cell]) -> None:
        """Draw these tiles from now on, with waves on slippery cells."""
        self.rows, self.slippery = rows, slippery
        self.stale = True

    def draw(self, renderer: Any) -> None:
        """Paint the tiles in the size of the cells, or resize larger ones if this is impossible."""
        axes = self.axes
        assert axes is not None, "tiles are in axes"
        box, enlarged = axes.bbox, renderer.get_image_magnification()
        cell = cell_of(axes) * enlarged
        side = min(max(math.ceil(cell - 0.01), 2), MAX_TILE_PIXELS)
        pixels = paint_once(codes_of(self.rows, self.slippery), side)
        width, height = (max(1, round(length * enlarged)) for length in (box.width, box.height))
        cut = axes.get_xlim()[0] * side
        if abs(side - cell) * pixels.shape[1] / side < 1:
            top, left = (
                (have - need) // 2
                for have, need in zip(pixels.shape[:2], (height, width), strict=True)
            )
            image = Image.fromarray(pixels[top : top + height, left : left + width])
        else:
            shown = (cut, cut, pixels.shape[1] - cut, pixels.shape[0] - cut)
            image = Image.fromarray(pixels).resize((width, height), Image.Resampling.LANCZOS, shown)
        rows = np.asarray(image.convert("RGBA"))[::-1]
        renderer.draw_image(renderer.new_gc(), round(box.x0), round(box.y0), rows)
        self.stale = False


class View:
    """The floor of a track in axes with row 0 at the top; ``cell_points`` is the side of a cell."""

    def __init__(self, figure: SceneFigure, axes: Axes, cell_points: float, track: Track) -> None:
        self._track, self._point, self.has_arrows = track, 1 / cell_points, True
        first = track.frames[0]
        height, width = len(first.tiles), len(first.tiles[0])
        largest = max(height, width)
        draw_grid(axes, (height, width), 1 if largest <= 20 else 5 if largest <= 60 else 10, 0)
        outer = track.outer
        axes.set(xlim=(outer, width - outer), ylim=(height - outer, outer), aspect="equal")
        axes.xaxis.tick_top()
        self._inside = outer, outer, width - outer, height - outer
        self._tiles, self._stations, self._traces, self._bodies = (
            Tiles(),
            *(Shapes() for _ in range(3)),
        )
        axes.add_artist(self._tiles)
        axes.add_artist(self._stations)
        figure.add_movers(axes, self._traces, self._bodies)
        self._history = History()
        self._settled: tuple[TileRows, int] | None = None

    def show(self, frames: Sequence[Frame], number: int) -> None:
        """Draw a frame, with the trails and visited cells up to it."""
        frame = frames[number]
        if frame.tiles is not self._tiles.rows:
            self._tiles.show(frame.tiles, self._track.slippery)
            self._stations.show(self._small_stations(frame.tiles))
        shapes = [*self._marked(frame), *self._route(frame), *self._ghost(number)]
        shapes += self._seen(frame)
        if frame.fleet:
            shapes += self._fleet(frame, frame.fleet)
        elif frame.robots:
            self._history.read(frames)
            step = math.floor(frame.progress)
            if self._settled != (frame.tiles, step):
                self._settled = frame.tiles, step
                self._traces.show(self._left_behind(frames, step))
            shapes += self._lone(frames, number)
        self._bodies.show([*shapes, *self._hits(frame), *self._ends()])

    def _least(self, cells: float, points: float) -> float:
        """Return a length in cells, enlarged if necessary to a least length in points."""
        return max(cells, points * self._point)

    def _small_stations(self, rows: TileRows) -> Iterator[Shape]:
        """Yield enlarged squares of stations if cells are too small for the default ones."""
        side = MIN_STATION * self._point
        if side > 1 - 2 * LOOK["station"]["inset"]:
            for tile in (PICKUP, DROPOFF, CHARGER):
                places = [(col + 0.5, row + 0.5) for row, col in cells_of(tile, rows)]
                yield Shape(stamped(side * SQUARE, places), COLORS[tile])

    def _marked(self, frame: Frame) -> Iterator[Shape]:
        """Yield the cells that a search has marked so far, in their colours."""
        marks = self._track.marks
        if marks is None:
            return
        end, inset = bisect_right(marks.times, frame.clock), LOOK["mark"]["inset"]
        cells: dict[int, list[Point]] = {}
        for cell, value in dict(zip(marks.cells[:end], marks.values[:end], strict=True)).items():
            cells.setdefault(value, []).append(middle(cell))
        for value, places in cells.items():
            yield Shape(stamped((1 - 2 * inset) * SQUARE, places), marks.colors[value])

    def _route(self, frame: Frame) -> Iterator[Shape]:
        """Yield the planned path of a robot as dots, or the path that a search found as a line."""
        path = lines([frame.route])
        if self._track.marks is None:
            yield Shape(path, None, "ink", self._least(WIDTHS["route"], 1.8), DOTS)
        else:
            for color, width in (("paper", 0.42), ("warning", 0.24)):
                yield Shape(path, None, color, self._least(width, 2))

    def _ghost(self, number: int) -> Iterator[Shape]:
        """Yield the outline of the robot of another track."""
        ghost, radius = self._track.ghost[number : number + 1], self._least(RADIUS, MIN_RADIUS)
        yield Shape(stamped(radius * CIRCLE, ghost), None, "ink", self._least(RIM, 1), GHOST)

    def _seen(self, frame: Frame) -> Iterator[Shape]:
        """Yield the rays of a range scan, unless arrows are hidden, and the outlines of things."""
        for name, is_ray, dashes in (("outline", False, ()), ("ray", True, DOTS)):
            shown = [(at, to) for is_one, at, to in frame.lines if is_one == is_ray]
            if shown and (self.has_arrows or not is_ray):
                yield Shape(lines(shown), None, "ink", self._least(WIDTHS[name], 0.8), dashes)

    def _ends(self) -> Iterator[Shape]:
        """Yield the start and the goal of a search, as letters on discs."""
        marks, rim = self._track.marks, self._least(RIM, MIN_LINE)
        radius, size = (self._least(LOOK["end"][key], MIN_END) for key in ("radius", "letter"))
        for letter, cell in zip("SG", marks.ends if marks else (), strict=bool(marks)):
            yield Shape(stamped(radius * CIRCLE, middle(cell)), "paper", "ink", rim)
            yield Shape(written(letter, size, middle(cell)), "ink")

    def _left_behind(self, frames: Sequence[Frame], step: int) -> Iterator[Shape]:
        """Yield tints of visited cells, a shadow on what the robot cannot see, and its trail."""
        rows, history = frames[self._history.frames[step]].tiles, self._history
        tints: dict[int, list[Point]] = {}
        for (row, col), entries in history.entries(step).items():
            often = min(len(entries) // 2, len(VISITED)) - 1
            if often >= 0 and rows[row][col] == EMPTY and (row, col) not in self._track.slippery:
                tints.setdefault(often, []).append((col, row))
        for tint, places in tints.items():
            yield Shape(stamped(BAR, places), VISITED[tint])
        here, radius = history.cells[step], self._track.view_radius
        if here is not None and radius is not None:
            yield Shape(around_view(here, radius, self._inside), "ink", alpha=SHADOW)
        width = self._least(WIDTHS["trail"], 1)
        for loaded, age, routes in trail_of(frames, history.frames, step):
            dashes = DASHES if loaded else ()
            yield Shape(lines(routes), None, faded_trail(loaded, age), width, dashes)
        yield self._skids(frames[: history.frames[step] + 1])

    def _skids(self, frames: Sequence[Frame]) -> Shape:
        """Return the skid marks of a robot in some frames."""
        marks = skids_of(frames, 0) if self._track.slippery else ()
        return Shape(lines(line for _, line in marks), None, SKID, LOOK["skid"]["width"])

    def _lone(self, frames: Sequence[Frame], number: int) -> Iterator[Shape]:
        """Yield a single robot, its trail since the last complete step, and its items."""
        frame, history = frames[number], self._history
        first = history.frames[math.floor(frame.progress)]
        poses = [each.robots[0] for each in frames[first : number + 1]]
        loaded = bool(poses[0] and poses[0].loaded)
        leg = lines([[pose.at for pose in poses if pose is not None]])
        width, dashes = self._least(WIDTHS["trail"], 1), DASHES if loaded else ()
        yield Shape(leg, None, TRAIL_COLORS[loaded], width, dashes)
        yield self._skids(frames[first : number + 1])
        side, thin = self._least(ITEMS["side"], MIN_ITEM), self._least(ITEMS["line"], MIN_LINE)
        at_rest = {cell for at, cell in history.delivered if at <= number}
        if not history.starts_loaded and not any(at <= number for at in history.taken):
            at_rest.update(cells_of(PICKUP, frame.tiles))
        places = [(col + ITEMS["place"], row + ITEMS["place"]) for row, col in sorted(at_rest)]
        yield Shape(stamped(side * SQUARE, places), "item", "ink", thin)
        pose = poses[-1]
        if pose is None:
            return
        radius, rim = self._least(RADIUS, MIN_RADIUS), self._least(RIM, MIN_LINE)
        yield from self._robots([pose], [color_of(pose)], radius, rim)
        if pose.loaded:
            side = CARRIED["side"] if self._track.is_continuous else side
            yield Shape(stamped(side * radius / RADIUS * SQUARE, pose.at), "item", "ink", thin)
        if self._track.is_continuous:
            return
        size = self._least(LETTER, MIN_LETTER)
        letter = written(ROBOT_LOADED if pose.loaded else ROBOT_EMPTY, size, pose.at)
        yield from outlined(letter, size, "ink" if pose.loaded else "paper")

    def _robots(
        self, poses: Sequence[Pose], colors: Sequence[str], radius: float, rim: float
    ) -> Iterator[Shape]:
        """Yield robots without items. Bodies have arrows, a chassis and wheels or a ring.

        The lines around robots with weak motors are dashed.
        """
        dashes = WEAK_MOTOR if self._track.motor_strength < 1 else ()
        scale = radius / RADIUS
        is_body = self._track.is_continuous and radius >= MIN_BODY * self._point
        if is_body:
            yield from self._arrows(poses)
            yield from self._wheels(poses, scale, rim)
        else:
            heading = [pose for pose in poses if pose.heading is not None]
            yield Shape(placed(NOSE * scale, heading), "ink")
        for color in dict.fromkeys(colors):
            mine = [pose for pose, each in zip(poses, colors, strict=True) if each == color]
            disc = stamped(radius * CIRCLE, [pose.at for pose in mine])
            yield Shape(
                placed(CHASSIS * scale, mine) if is_body else disc, color, "ink", rim, dashes
            )
        if is_body:
            yield Shape(placed(FRONT * scale, poses), "paper", "ink", rim / 2)

    def _wheels(self, poses: Sequence[Pose], scale: float, rim: float) -> Iterator[Shape]:
        """Yield the wheels or the rings of bodies, and their brake lights."""
        for corners in DRIVES.get(self._track.drive, ()):
            yield Shape(placed(corners * scale, poses), "ink")
        braking = [pose for pose in poses if pose.push and pose.push.brakes]
        yield Shape(placed(LAMP * scale, braking), "brake", "paper", rim / 2)

    def _arrows(self, poses: Sequence[Pose]) -> Iterator[Shape]:
        """Yield arrows for the forces and velocities of bodies, from their centres."""
        wide = LOOK["arrows"]["wide"]
        for name, width in (("force", wide), ("velocity", 1.0)):
            for pose in poses if self.has_arrows else ():
                right, down = arrow_tip(name, getattr(pose.push, name, (0.0, 0.0)))
                if (right, down) == (0, 0):
                    continue
                angle, tip = math.atan2(down, right), math.hypot(right, down)
                half, head = WIDTHS["arrow"] * width / 2, HEAD[[1, 0, 2]] * width + (tip, 0)
                corners = np.array([(0, half), (tip, half), *head, (tip, -half), (0, -half)])
                path = polygons([turned(corners, angle) + pose.at])
                yield Shape(path, name, "paper", RIM / 2)

    def _fleet(self, frame: Frame, fleet: FleetFrame) -> Iterator[Shape]:
        """Yield the robots of a fleet, with their plans, batteries and items, people and orders."""
        poses = [pose for pose in frame.robots if pose is not None]
        count = len(fleet.battery)
        robots, places = poses[:count], np.array([pose.at for pose in poses[:count]])
        grown = min(MAX_RADIUS, self._least(RADIUS, GOOD_RADIUS))
        radius, rim = self._least(grown, MIN_FLEET_RADIUS), self._least(RIM, MIN_LINE / 2)
        scale = radius / RADIUS
        colors = [color_of(pose, share) for pose, share in zip(robots, fleet.battery, strict=True)]
        yield from self._plans(fleet, colors)
        people = [person.at for person in poses[count:]]
        yield Shape(stamped(scale * DIAMOND, people), "person", "ink", rim)
        yield from self._batteries(places, fleet.battery, scale, rim)
        yield from self._robots(robots, colors, radius, rim)
        size = min(LETTER, NAME / len(str(count - 1))) * scale
        if size >= MIN_NUMBER * self._point:
            names = [written(str(robot), size, at) for robot, at in enumerate(places)]
            if people:
                yield from outlined(joined([written(PERSON, size, at) for at in people]), size)
            for is_loaded in (False, True):
                same = [name for name, color in zip(names, colors, strict=True)
                        if (color == "loaded") == is_loaded]  # fmt: skip
                if same:
                    yield from outlined(joined(same), size, "ink" if is_loaded else "paper")
        away = scale * CARRIED["away"] * np.array((1, -1))
        for age, color in enumerate(ORDERS):
            mine = [place + away for place, each in zip(places, fleet.items, strict=True)
                    if each == age]  # fmt: skip
            yield Shape(stamped(scale * CARRIED["side"] * SQUARE, mine), color, ink_on(age), rim)
        for pusher, robot in ((by, robot) for robot, by in fleet.plans.pushers.items()):
            ahead, middle = places[robot] - places[pusher], (places[robot] + places[pusher]) / 2
            arrow = turned(ARROW, math.atan2(ahead[1], ahead[0]))
            yield Shape(stamped(arrow, middle), "ink", "paper", rim)
        for at, number, age in fleet.waiting:
            yield from self._orders(at, f"{number}{'!' * (age == LATE)}", age, rim)

    def _plans(self, fleet: FleetFrame, colors: Sequence[str]) -> Iterator[Shape]:
        """Yield the planned paths of robots, fading with time, and their unplanned rest as dots."""
        planned, wishes, _ = fleet.plans
        for paths, width, dashes in ((planned, WIDTHS["plan"], ()), (wishes, WIDTHS["wish"], DOTS)):
            for robot, path in paths.items():
                first = len(planned.get(robot, ())) - 1 if paths is wishes else 0
                for time, (before, after) in enumerate(pairwise(path), first):
                    if before != after:
                        leg = [(col + 0.5, row + 0.5) for row, col in (before, after)]
                        share = min(time / FADE_STEPS, 1) * MAX_FADE
                        faded = blend(color_named(colors[robot]), COLORS[EMPTY], share)
                        yield Shape(lines([leg]), None, faded, self._least(width, 2), dashes)

    def _batteries(
        self, places: Points, battery: Sequence[float], scale: float, rim: float
    ) -> Iterator[Shape]:
        """Yield a bar below each disc; in large fleets only below robots with a low battery."""
        low, length, height = BATTERIES["low"], 2 * RADIUS * scale, BATTERIES["height"] * scale
        corner = np.array((-length / 2, BATTERIES["top"] * scale))
        shown = [
            (place + corner, share)
            for place, share in zip(places, battery, strict=True)
            if len(battery) <= BATTERIES["few"] or share < low
        ]
        yield Shape(stamped(BAR * (length, height), [at for at, _ in shown]), "paper", "ink", rim)
        for is_low, color in ((False, "battery"), (True, "warning")):
            bars = [
                at + BAR * (share * length, height)
                for at, share in shown
                if (share < low) == is_low
            ]
            yield Shape(polygons(bars), color)

    def _orders(self, at: Point, words: str, age: int, rim: float) -> Iterator[Shape]:
        """Yield the number of orders at a pickup, in a box with the colour of their age."""
        size = self._least(ITEMS["side"], MIN_ORDERS)
        place = tuple(part - 0.5 + ITEMS["place"] for part in at)
        box = SQUARE * size * (max(glyphs(words)[1] + 0.4, 1.15), 1.15)
        yield Shape(stamped(box, place), ORDERS[age], ink_on(age), rim)
        yield Shape(written(words, size, place), ink_on(age))

    def _hits(self, frame: Frame) -> Iterator[Shape]:
        """Yield a star for each hit, and a label for the last one."""
        radius = self._least(STAR_RADIUS, MIN_FLEET_HIT if frame.fleet else MIN_HIT)
        star, rim = STAR * (radius / STAR_RADIUS), self._least(RIM / 2, MIN_LINE)
        stars = [star * hit.size + hit.at for hit in frame.hits]
        yield Shape(polygons(stars), "hit", "ink", rim)
        if frame.hits and frame.hits[-1].label:
            radius *= frame.hits[-1].size
            (x, y), size = frame.hits[-1].at, LABEL * self._point
            half = (glyphs(frame.hits[-1].label)[1] + 0.8) * size / 2
            left, top, right, _ = self._inside
            place = max(min(x, right - half), left + half), max(y - radius - size, top + size)
            yield Shape(stamped(SQUARE * (2 * half, 1.5 * size), place), "hit")
            yield Shape(written(frame.hits[-1].label, size, place), "ink")


def trail_of(
    frames: Sequence[Frame], ends: Sequence[int], step: int
) -> Iterator[tuple[bool, float, list[list[Point]]]]:
    """Yield the trail of a robot in pieces, the oldest first: its load, age and lines.

    ``ends`` has the frame in which each step is complete.
    """
    steps = LOOK["trail"]["steps"]
    pieces: list[tuple[bool, float, list[list[Point]]]] = []
    recent = ends[max(0, step - steps) : step + 1]
    numbers = [n for first, end in pairwise(recent) for n in range(first, end, FRAMES_APART)]
    for before, after in pairwise([*numbers, recent[-1]]):
        start, end = frames[before].robots[0], frames[after].robots[0]
        if start is None or end is None:
            continue
        age = int(FADES * min((step - frames[before].progress) / steps, 0.999)) / FADES
        if not pieces or pieces[-1][:2] != (start.loaded, age):
            pieces.append((start.loaded, age, []))
        routes = pieces[-1][2]
        if not routes or routes[-1][-1] != start.at:
            routes.append([start.at])
        routes[-1].append(end.at)
    yield from pieces


def around_view(cell: Cell, radius: int, shown: tuple[float, float, float, float]) -> Path:
    """Return the visible area without the square window of a robot's view, as a path with a hole.

    Args:
        cell: cell in the middle of the window.
        radius: number of cells from there to the edge of the window.
        shown: left, top, right and bottom of the visible area.
    """
    (row, col), (left, top, right, bottom) = cell, shown
    first, last = max(col - radius, left), min(col + radius + 1, right)
    upper, lower = max(row - radius, top), min(row + radius + 1, bottom)
    whole = [(left, top), (right, top), (right, bottom), (left, bottom)]
    return polygons([whole, [(first, upper), (first, lower), (last, lower), (last, upper)]])


def placed(shape: Points, poses: Iterable[Pose]) -> Path:
    """Return one path with a shape of robots at their positions, turned to their headings."""
    return polygons([turned(shape, pose.heading or 0.0) + pose.at for pose in poses])


def turned(shape: Points, angle: float) -> Points:
    """Return a shape ``[N, 2]`` that points east, turned by an angle in radians."""
    cos, sin = math.cos(angle), math.sin(angle)
    corners: Points = shape @ np.array([(cos, sin), (-sin, cos)])
    return corners


def color_of(pose: Pose, share: float = 1.0) -> str:
    """Return the name of the colour of a robot with a share of a full battery."""
    return "stranded" if share <= 0 else "loaded" if pose.loaded else "robot"


def ink_on(age: int) -> str:
    """Return the name of the colour of the text on an order, and of the line around it."""
    return "paper" if age == LATE else "ink"
