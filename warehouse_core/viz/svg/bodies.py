"""The moving parts of an animated drawing: robots, people, items, orders, plans and hits.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np

from warehouse_core.render.palette import LOOK
from warehouse_core.viz.svg.beat import Beat, Span, extend, spans_of
from warehouse_core.viz.svg.floor import UNIT, box, shape
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Point, Pose, Track
from warehouse_core.world.tiles import PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, Cell

Value = TypeVar("Value")

ROBOT, ITEM, CARRIED, BATTERY = (LOOK[name] for name in ("robot", "item", "carried", "battery"))

RADIUS = round(UNIT * ROBOT["radius"])
"""Radius of a robot."""

ORDERS = ("item", "order-older", "order-nearly-due", "order-late")
"""Names of the colours of orders, by age."""

LATE = len(ORDERS) - 1

MIN_NAMED = 20
"""Least side of a cell, in pixels, for which the number of a robot is legible."""

MAX_VISITS = 5
"""Number of visits to a cell after which its colour no longer changes."""


def bodies_of(track: Track, numbers: Sequence[int], beat: Beat, pixels: float) -> Iterator[str]:
    """Yield everything on the floor in some frames of a track, from the lowest to the highest.

    ``numbers`` has the number of each frame in the track. ``pixels`` is the side of a cell. In
    small cells, robots have no numbers.
    """
    frames = [track.frames[number] for number in numbers]
    ghost = [track.ghost[number] for number in numbers if track.ghost]
    fleets = [frame.fleet for frame in frames if frame.fleet is not None]
    robots = len(fleets[0].battery) if fleets else len(frames[0].robots)
    if not fleets:
        for robot in range(robots):
            yield from _traces(track, frames, robot, beat)
    yield from _lines(frames, beat)
    yield from _orders(frames, beat)
    if ghost:
        places = [(round(UNIT * x), round(UNIT * y)) for x, y in ghost]
        yield beat.jumping(f'<circle r="{RADIUS}" class="ghost of-ink"/>', places)
    for body in range(len(frames[0].robots)):
        poses = [frame.robots[body] for frame in frames]
        if not any(poses):
            continue
        if body >= robots:
            drawn = f"{shape('H', 'person of-rim')}{_name(PERSON, 1, 'light')}"
        elif fleets:
            drawn = _fleet_robot(fleets, body, poses, beat, is_named=pixels >= MIN_NAMED)
        else:
            drawn = _lone_robot(poses, beat)
        places = [(round(UNIT * x), round(UNIT * y)) for x, y in (p.at for p in _filled(poses))]
        there = spans_of(pose is not None for pose in poses)[True]
        yield beat.shown(beat.moving(_nose(poses, beat) + drawn, places), there)
    for at, spans in _hits(frames).items():
        x, y = (round(UNIT * place) for place in at)
        place = f'transform="translate({x} {y})"'
        yield beat.shown(shape("hit", "hit of-rim", place), spans)


def _filled(values: Iterable[Value | None]) -> list[Value]:
    """Return values with each ``None`` replaced by the value before it, or by the first value."""
    values = [*values]
    now = next(value for value in values if value is not None)
    return [now := now if value is None else value for value in values]


def _nose(poses: Sequence[Pose | None], beat: Beat) -> str:
    """Return the nose of a body, shown in the frames in which the body has a heading."""
    headings = [pose.heading if pose else None for pose in poses]
    has_one = spans_of(heading is not None for heading in headings).get(True)
    if has_one is None:
        return ""
    degrees = np.degrees(np.unwrap(_filled(headings))).round().astype(int).tolist()
    return beat.shown(beat.turning(shape("nose", "rim"), degrees), has_one)


def _lone_robot(poses: Sequence[Pose | None], beat: Beat) -> str:
    is_loaded = spans_of(pose is not None and pose.loaded for pose in poses)
    empty = _disc("robot") + _name(ROBOT_EMPTY, 1, "light")
    loaded = _disc("loaded") + _item(0, 0, ITEM["side"], "item") + _name(ROBOT_LOADED, 1, "dark")
    return beat.shown(empty, is_loaded.get(False, [])) + beat.shown(loaded, is_loaded.get(True, []))


def _fleet_robot(
    fleets: Sequence[FleetFrame],
    robot: int,
    poses: Sequence[Pose | None],
    beat: Beat,
    *,
    is_named: bool,
) -> str:
    """Return a robot with its number, battery and item; large fleets show only low batteries."""
    robots, levels = len(fleets[0].battery), [fleet.battery[robot] for fleet in fleets]
    name, digits = str(robot) if is_named else "", len(str(robots - 1))

    def draw_disc(look: str) -> str:
        return _disc(look) + _name(name, digits, "dark" if look == "loaded" else "light")

    def draw_item(age: int | None) -> str:
        away = round(UNIT * CARRIED["away"])
        return "" if age is None else _item(away, -away, CARRIED["side"], ORDERS[age])

    looks = [
        "stranded" if level <= 0 else "loaded" if pose is not None and pose.loaded else "robot"
        for level, pose in zip(levels, poses, strict=True)
    ]
    parts = [*beat.each(looks, draw_disc), *beat.each((f.items[robot] for f in fleets), draw_item)]
    is_low = spans_of(level < BATTERY["low"] for level in levels)
    width, animation = beat.growing("width", [round(2 * RADIUS * level) for level in levels])
    top, high = round(UNIT * BATTERY["top"]), round(UNIT * BATTERY["height"])
    ground = box(-RADIUS - 1, top - 1, 2 * RADIUS + 2, high + 2, "light of-rim")
    place = f'x="{-RADIUS}" y="{top}" height="{high}"'
    for low, look in ((False, "battery"), (True, "warning")):
        if low or robots <= BATTERY["few"]:
            bar = f'<rect {place} {width} class="{look}">{animation}</rect>'
            parts.append(beat.shown(ground + bar, is_low.get(low, [])))
    return "".join(parts)


def _disc(look: str) -> str:
    return f'<circle r="{RADIUS}" class="{look} of-rim"/>'


def _name(text: str, digits: int, look: str) -> str:
    if not text:
        return ""
    size = round(UNIT * min(ROBOT["letter"], ROBOT["name"] / digits))
    rim = " of-dark" if look == "light" else ""
    return f'<text y="{0.36 * size:.0f}" font-size="{size}" class="{look}{rim}">{text}</text>'


def _item(x: int, y: int, share: float, look: str) -> str:
    """Return a box with a strip of tape around a centre; its side is a share of a cell."""
    half = round(UNIT * share / 2)
    down, line = UNIT * share * ITEM["tape"] / ITEM["side"], UNIT * ITEM["line"]
    tape = f'<path d="M{x} {y - half}v{down:g}" class="of-dark" stroke-width="{line:g}"/>'
    return box(x - half, y - half, 2 * half, 2 * half, f"{look} of-rim") + tape


def _item_in(cell: Cell) -> str:
    row, col = (round(UNIT * (place + ITEM["place"])) for place in cell)
    return _item(col, row, ITEM["side"], "item")


def _orders(frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the number of orders that wait at each pickup, in the colour of the oldest one."""
    waiting: dict[Point, list[tuple[int, int] | None]] = {}
    for number, frame in enumerate(frames):
        for at, count, age in frame.fleet.waiting if frame.fleet else ():
            waiting.setdefault(at, [None] * len(frames))[number] = count, age
    for (x, y), states in waiting.items():
        col, row = round(UNIT * (int(x) + ITEM["place"])), round(UNIT * (int(y) + ITEM["place"]))

        def draw(state: tuple[int, int] | None, col: int = col, row: int = row) -> str:
            if state is None:
                return ""
            count, age = state
            words = f"{count}{'!' * (age == LATE)}"
            half, look = round(UNIT * ITEM["side"] / 2), "light" if age == LATE else "dark"
            size = 1.6 * half if len(words) == 1 else 2.4 * half / len(words)
            inner = box(col - half, row - half, 2 * half, 2 * half, f"{ORDERS[age]} of-rim")
            text = f'<text x="{col}" y="{row + 0.36 * size:.0f}" font-size="{size:.0f}"'
            return f'{inner}{text} class="{look}">{words}</text>'

        yield from beat.each(states, draw)


def _hits(frames: Sequence[Frame]) -> dict[Point, list[Span]]:
    """Return the spans of the hits at each position."""
    found: dict[Point, list[Span]] = {}
    for number, frame in enumerate(frames):
        for at in {hit.at for hit in frame.hits}:
            extend(found.setdefault(at, []), number, number + 1)
    return found


def _lines(frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the planned paths of robots, and an arrow for each robot that pushes another."""
    yield from beat.each(
        (frame.route for frame in frames), lambda route: _path(route, "plan dots") if route else ""
    )
    drawn: dict[str, list[Span]] = {}
    for number, frame in enumerate(frames):
        for line in _plans(frame):
            extend(drawn.setdefault(line, []), number, number + 1)
    for line, spans in drawn.items():
        yield beat.shown(line, spans)


def _plans(frame: Frame) -> Iterator[str]:
    """Yield the plans of a fleet in a frame."""
    if frame.fleet is None:
        return
    paths, wishes, pushers = frame.fleet.plans
    for plans, look in ((paths, "plan"), (wishes, "plan dots")):
        for cells in plans.values():
            yield _path([(col + 0.5, row + 0.5) for row, col in cells], look)
    for pushed, pusher in pushers.items():
        (x, y), (right, down) = (
            pose.at for pose in (frame.robots[pusher], frame.robots[pushed]) if pose is not None
        )
        angle = round(math.degrees(math.atan2(down - y, right - x)))
        at = f"{UNIT * (x + right) / 2:.0f} {UNIT * (y + down) / 2:.0f}"
        place = f'transform="translate({at}) rotate({angle})" stroke-width="3"'
        yield shape("push", "rim of-light", place)


def _places(points: Iterable[Point]) -> str:
    return " ".join(f"{UNIT * x:.0f},{UNIT * y:.0f}" for x, y in points)


def _path(points: Iterable[Point], look: str) -> str:
    return f'<polyline points="{_places(points)}" class="{look} of-ink"/>'


def _traces(track: Track, frames: Sequence[Frame], robot: int, beat: Beat) -> Iterator[str]:
    """Yield the visited cells, trail and items of a robot, and a shadow on what it cannot see."""
    history, rows = History(robot), frames[0].tiles
    history.read(frames)
    yield from _visits(history, beat)
    poses = [frame.robots[robot] for frame in frames]
    yield from _trail(poses, beat)
    if not history.starts_loaded:
        waits = [(0, history.taken[0] if history.taken else beat.frames)]
        for cell in ((row, col) for row, line in enumerate(rows) for col in range(len(line))):
            if rows[cell[0]][cell[1]] == PICKUP:
                yield beat.shown(_item_in(cell), waits)
    for frame, cell in history.delivered:
        yield beat.shown_from(_item_in(cell), frame)
    if track.view_radius is not None and len(frames[0].robots) == 1 and None not in poses:
        first, side = -UNIT * track.view_radius, UNIT * (2 * track.view_radius + 1)
        far = UNIT * 2 * max(len(rows), len(rows[0]))
        window = f"M{-far}-{far}H{far}V{far}H{-far}zM{first} {first}v{side}h{side}v-{side}z"
        cells = [(UNIT * int(p.at[0]), UNIT * int(p.at[1])) for p in poses if p is not None]
        yield beat.jumping(f'<path d="{window}" class="shadow"/>', cells)


def _visits(history: History, beat: Beat) -> Iterator[str]:
    """Yield tints of the cells that a robot has entered more than once."""
    came: dict[Cell, list[int]] = {}
    before = None
    for number, cell in zip(history.frames, history.cells, strict=True):
        if cell is not None and cell != before:
            came.setdefault(cell, []).append(number)
        before = cell or before
    for (row, col), times in came.items():
        tint = box(UNIT * col, UNIT * row, UNIT, UNIT, "visited")
        for first in times[1:MAX_VISITS]:
            yield beat.shown_from(tint, first)


def _trail(poses: Sequence[Pose | None], beat: Beat) -> Iterator[str]:
    """Yield the trail of a robot, which grows behind it, in the colours of its load."""
    looks = spans_of(pose and ("loaded" if pose.loaded else "robot") for pose in poses)
    for look, (first, end) in [(look, span) for look, spans in looks.items() for span in spans]:
        last = min(end, beat.frames - 1)
        path = [pose.at for pose in poses[first : last + 1] if pose is not None]
        driven = np.cumsum([0.0, *(math.dist(one, other) for one, other in pairwise(path))])
        length = round(UNIT * float(driven[-1]))
        if not look or not length or len(path) != last + 1 - first:
            continue
        left = length - np.round(UNIT * driven).astype(int)
        offsets = [length] * first + left.tolist() + [0] * (beat.frames - 1 - last)
        offset, animation = beat.growing("stroke-dashoffset", offsets)
        corners = [path[0], *(now for before, now in pairwise(path) if now != before)]
        yield (
            f'<polyline points="{_places(corners)}" pathLength="{length}" '
            f'stroke-dasharray="{length} {length}" {offset} class="trail of-{look}">'
            f"{animation}</polyline>"
        )
