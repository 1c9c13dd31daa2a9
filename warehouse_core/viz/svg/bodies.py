"""The moving parts of an animated drawing: robots, people, items, orders, plans and hits.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby, pairwise
from typing import TypeVar

import numpy as np

from warehouse_core.render.palette import LOOK
from warehouse_core.viz.svg.beat import Beat, Span, extend, spans_of
from warehouse_core.viz.svg.floor import UNIT, box, shape
from warehouse_core.viz.tracks.history import History, skids_of
from warehouse_core.viz.tracks.track import (
    DrawnHit,
    FleetFrame,
    Frame,
    Line,
    Point,
    Pose,
    Track,
    arrow_tip,
)
from warehouse_core.world.tiles import PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, Cell

Value = TypeVar("Value")

ROBOT, ITEM, CARRIED, BATTERY, ARROWS = (
    LOOK[name] for name in ("robot", "item", "carried", "battery", "arrows")
)

RADIUS = round(UNIT * ROBOT["radius"])
"""Radius of a robot."""

ORDERS = ("item", "order-older", "order-nearly-due", "order-late")
"""Names of the colours of orders, by age."""

LATE = len(ORDERS) - 1

MIN_NAMED = 20
"""Least side of a cell, in pixels, for which the number of a robot is legible."""

LABEL = 32
"""Size of the text next to a hit."""

COARSE = 4
"""Unit of the lengths of arrows. Finer ones would make drawings larger."""

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
    for robot in range(robots if track.slippery else 0):
        yield from _skids(frames, robot, beat)
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
            is_named = pixels >= MIN_NAMED
            drawn = _fleet_robot(track, fleets, body, poses, beat, is_named=is_named)
        else:
            drawn = _lone_robot(track, poses, beat)
        if body >= robots or not track.is_continuous or (fleets and pixels < MIN_NAMED):
            drawn = _turned(shape("nose", "rim"), poses, beat) + drawn
        if fleets and body < robots:
            drawn = _battery(fleets, body, beat) + drawn
        places = [(round(UNIT * x), round(UNIT * y)) for x, y in (p.at for p in _filled(poses))]
        there = spans_of(pose is not None for pose in poses)[True]
        yield beat.shown(beat.moving(drawn, places), there)
    for hit, spans in _hits(frames).items():
        x, y = (round(UNIT * place) for place in hit.at)
        place = f'transform="translate({x} {y}) scale({hit.size:.3g})"'
        words = f'<text x="{x}" y="{y - LABEL * hit.size:.0f}" font-size="{LABEL}" '
        words = f'{words}class="light of-dark">{html.escape(hit.label)}</text>' if hit.label else ""
        yield beat.shown(shape("hit", "hit of-rim", place) + words, spans)


def _filled(values: Iterable[Value | None]) -> list[Value]:
    """Return values with each ``None`` replaced by the value before it, or by the first value."""
    values = [*values]
    now = next(value for value in values if value is not None)
    return [now := now if value is None else value for value in values]


def _turned(inner: str, poses: Sequence[Pose | None], beat: Beat) -> str:
    """Return a part of a robot, turned with it, in the frames in which it has a heading."""
    headings = [pose.heading if pose else None for pose in poses]
    has_one = spans_of(heading is not None for heading in headings).get(True)
    if has_one is None:
        return ""
    degrees = np.degrees(np.unwrap(_filled(headings))).round().astype(int).tolist()
    return beat.shown(beat.turning(inner, degrees), has_one)


def _machine(track: Track, looks: Sequence[str], poses: Sequence[Pose | None], beat: Beat) -> str:
    """Return a body that turns: its wheels or ring, brake light, chassis and front.

    ``looks`` has the name of its colour in each frame.
    """
    wheel, ring, line = (UNIT * part for part in LOOK["body"].values())
    sides = [f'transform="translate(0 {side:g})"' for side in (-wheel, wheel)]
    drives = {
        "differential": [shape("wheel", "rim", side) for side in sides],
        "omnidirectional": [f'<circle r="{ring:g}" class="of-rim ring" stroke-width="{line:g}"/>'],
    }
    parts = drives.get(track.drive, [])
    brakes = spans_of(bool(pose and pose.push and pose.push.brakes) for pose in poses)
    parts.append(
        beat.shown(shape("brake", "brake of-light", 'style="stroke-width:2"'), brakes.get(True, []))
    )
    parts += beat.each(looks, lambda look: shape("chassis", f"{look} of-rim"))
    parts.append(shape("front", "light of-rim", 'style="stroke-width:2"'))
    return _turned("".join(parts), poses, beat)


def _arrows(poses: Sequence[Pose | None], beat: Beat) -> Iterator[str]:
    """Yield arrows for the force and the velocity of a body."""
    pushes = [pose.push if pose else None for pose in poses]
    for name, wide in (("force", ARROWS["wide"]), ("velocity", 1.0)):
        ends = [arrow_tip(name, getattr(push, name, (0.0, 0.0))) for push in pushes]
        tips = [tuple(COARSE * round(UNIT * part / COARSE) for part in end) for end in ends]
        x, moves_x = beat.growing("x2", [tip[0] for tip in tips])
        y, moves_y = beat.growing("y2", [tip[1] for tip in tips])
        width = UNIT * LOOK["lines"]["arrow"] * wide
        line = (
            f'<line {x} {y} stroke-width="{width:g}" class="of-{name}" marker-end="url(#{name})">'
        )
        shown = spans_of(tip != (0, 0) for tip in tips).get(True, [])
        yield beat.shown(f"{line}{moves_x}{moves_y}</line>", shown)


def arrow_heads() -> str:
    """Return the definitions of the heads of the arrows."""
    return "".join(
        f'<marker id="{name}" markerUnits="userSpaceOnUse" orient="auto" overflow="visible">'
        + shape("arrow", name, f'transform="scale({wide})"')
        + "</marker>"
        for name, wide in (("force", ARROWS["wide"]), ("velocity", 1.0))
    )


def _lone_robot(track: Track, poses: Sequence[Pose | None], beat: Beat) -> str:
    is_loaded = spans_of(pose is not None and pose.loaded for pose in poses)
    if track.is_continuous:
        looks = ["loaded" if pose and pose.loaded else "robot" for pose in poses]
        item = beat.shown(_item(0, 0, CARRIED["side"], "item"), is_loaded.get(True, []))
        return "".join(_arrows(poses, beat)) + _machine(track, looks, poses, beat) + item
    empty = _disc("robot") + _name(ROBOT_EMPTY, 1, "light")
    loaded = _disc("loaded") + _item(0, 0, ITEM["side"], "item") + _name(ROBOT_LOADED, 1, "dark")
    return beat.shown(empty, is_loaded.get(False, [])) + beat.shown(loaded, is_loaded.get(True, []))


def _fleet_robot(
    track: Track,
    fleets: Sequence[FleetFrame],
    robot: int,
    poses: Sequence[Pose | None],
    beat: Beat,
    *,
    is_named: bool,
) -> str:
    """Return a robot with its number and item."""
    levels = [fleet.battery[robot] for fleet in fleets]
    name, digits = str(robot) if is_named else "", len(str(len(fleets[0].battery) - 1))

    is_body = track.is_continuous and is_named

    def draw_disc(look: str) -> str:
        words = _name(name, digits, "dark" if look == "loaded" else "light")
        return words if is_body else _disc(look) + words

    def draw_item(age: int | None) -> str:
        away = round(UNIT * CARRIED["away"])
        return "" if age is None else _item(away, -away, CARRIED["side"], ORDERS[age])

    looks = [
        "stranded" if level <= 0 else "loaded" if pose is not None and pose.loaded else "robot"
        for level, pose in zip(levels, poses, strict=True)
    ]
    parts = [*_arrows(poses, beat), _machine(track, looks, poses, beat)] if is_body else []
    parts += beat.each(looks, draw_disc)
    parts += beat.each((f.items[robot] for f in fleets), draw_item)
    return "".join(parts)


def _battery(fleets: Sequence[FleetFrame], robot: int, beat: Beat) -> str:
    """Return the bar of a battery, which lies below the disc; large fleets show only low ones."""
    levels = [fleet.battery[robot] for fleet in fleets]
    is_low = spans_of(level < BATTERY["low"] for level in levels)
    width, animation = beat.growing("width", [round(2 * RADIUS * level) for level in levels])
    top, high = round(UNIT * BATTERY["top"]), round(UNIT * BATTERY["height"])
    ground = box(-RADIUS - 1, top - 1, 2 * RADIUS + 2, high + 2, "light of-rim")
    place, drawn = f'x="{-RADIUS}" y="{top}" height="{high}"', ""
    for low, look in ((False, "battery"), (True, "warning")):
        if low or len(fleets[0].battery) <= BATTERY["few"]:
            bar = f'<rect {place} {width} class="{look}">{animation}</rect>'
            drawn += beat.shown(ground + bar, is_low.get(low, []))
    return drawn


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


def _hits(frames: Sequence[Frame]) -> dict[DrawnHit, list[Span]]:
    """Return the spans of the frames that show each hit; equal hits of several robots are one."""
    found: dict[DrawnHit, list[Span]] = {}
    for number, frame in enumerate(frames):
        for hit in dict.fromkeys(replace(hit, robot=0) for hit in frame.hits):
            extend(found.setdefault(hit, []), number, number + 1)
    return found


def _skids(frames: Sequence[Frame], robot: int, beat: Beat) -> Iterator[str]:
    """Yield the skid marks of a robot. The marks of a step appear at its end."""
    marks: dict[int, list[str]] = {}
    ends: dict[int, int] = {}
    for number, line in skids_of(frames, robot):
        step = math.ceil(frames[number].progress)
        (x, y), (to_x, to_y) = [[round(UNIT * part) for part in point] for point in line]
        marks.setdefault(step, []).append(f"M{x} {y}L{to_x} {to_y}")
        ends[step] = number
    width = f'stroke-width="{UNIT * LOOK["skid"]["width"]:g}"'
    for step, lines in marks.items():
        drawn = f'<path d="{"".join(lines)}" class="of-dark skid" {width}/>'
        yield beat.shown_from(drawn, ends[step])


def _lines(frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the planned paths of robots, and an arrow for each robot that pushes another."""
    yield from beat.each(
        (frame.route for frame in frames), lambda route: _path(route, "plan dots") if route else ""
    )
    yield from beat.each((frame.lines for frame in frames), _outlines)
    drawn: dict[str, list[Span]] = {}
    for number, frame in enumerate(frames):
        for line in _plans(frame):
            extend(drawn.setdefault(line, []), number, number + 1)
    for line, spans in drawn.items():
        yield beat.shown(line, spans)


def _outlines(lines: Sequence[Line]) -> str:
    """Return the outlines of things; a drawing with all rays would be several times as large."""
    parts = [f"M{_places([at])}L{_places([to])}" for is_ray, at, to in lines if not is_ray]
    width = UNIT * LOOK["lines"]["outline"]
    return f'<path d="{"".join(parts)}" class="of-ink" stroke-width="{width:g}"/>' if parts else ""


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
        # A body that turns on the spot moves by tiny amounts, which browsers draw as gaps.
        corners = [at for at, _ in groupby((round(x, 2), round(y, 2)) for x, y in path)]
        yield (
            f'<polyline points="{_places(corners)}" pathLength="{length}" '
            f'stroke-dasharray="{length} {length}" {offset} class="trail of-{look}">'
            f"{animation}</polyline>"
        )
