"""The moving parts of an animated drawing: robots, people, items, orders, plans and hits.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise
from typing import TypeVar

import numpy as np

from warehouse_core.records.plans import NO_PLANS
from warehouse_core.render.palette import LATE, LOOK, ORDERS
from warehouse_core.viz.svg.beat import Beat, spans_of
from warehouse_core.viz.svg.floor import UNIT, box, polygon, shape
from warehouse_core.viz.tracks.history import History, skids_of
from warehouse_core.viz.tracks.track import (
    DrawnHit,
    FleetFrame,
    Frame,
    Point,
    Pose,
    Track,
    Waiting,
    arrow_tip,
    cells_of,
    middle,
)
from warehouse_core.world.tiles import PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, Cell

Value = TypeVar("Value")

ROBOT, ITEM, CARRIED, BATTERY, ARROWS = (
    LOOK[name] for name in ("robot", "item", "carried", "battery", "arrows")
)

RADIUS = round(UNIT * ROBOT["radius"])
"""Radius of a robot."""

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
    for robot in range(robots):
        if not fleets:
            yield from _traces(track, frames, beat)
        if track.slippery:
            yield from _skids(frames, robot, beat)
    yield from beat.all_of(map(_lines, frames))
    yield from beat.all_of(_orders(frame.fleet.waiting if frame.fleet else ()) for frame in frames)
    if ghost:
        jumps = beat._replace(glides=False)
        yield jumps.moving(f'<circle r="{RADIUS}" class="ghost of-ink"/>', _hundredths(ghost))
    for body in range(len(frames[0].robots)):
        poses = [frame.robots[body] for frame in frames]
        if not any(poses):
            continue
        if body >= robots:
            drawn = f"{shape('H', 'person of-rim')}{_name(PERSON, 1, 'light')}"
        else:
            drawn = _robot(track, fleets, body, poses, beat, is_named=pixels >= MIN_NAMED)
        if body >= robots or not track.is_continuous or (fleets and pixels < MIN_NAMED):
            drawn = _turned(shape("nose", "rim"), poses, beat) + drawn
        if fleets and body < robots:
            drawn = _battery(fleets, body, beat) + drawn
        there = spans_of(pose is not None for pose in poses)[True]
        places = _hundredths(pose.at for pose in _filled(poses))
        yield beat.shown(beat.moving(drawn, places), there)
    yield from beat.all_of(map(_burst, frame.hits) for frame in frames)


def _hundredths(places: Iterable[Point]) -> list[tuple[int, int]]:
    """Return positions in hundredths of a cell."""
    return [(round(UNIT * x), round(UNIT * y)) for x, y in places]


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
    parts = [polygon(corners, "rim") for corners in LOOK["drives"].get(track.drive, ())]
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


def _robot(
    track: Track,
    fleets: Sequence[FleetFrame],
    robot: int,
    poses: Sequence[Pose | None],
    beat: Beat,
    *,
    is_named: bool,
) -> str:
    """Return a robot with its item, and its letter or number.

    A robot of a fleet carries its item next to its number.
    """
    loads = [pose is not None and pose.loaded for pose in poses]
    levels = [fleet.battery[robot] for fleet in fleets] or [1.0] * len(poses)
    items = [fleet.items[robot] for fleet in fleets] or [0 if load else None for load in loads]
    looks = [
        "stranded" if level <= 0 else "loaded" if load else "robot"
        for level, load in zip(levels, loads, strict=True)
    ]
    is_body = track.is_continuous and (is_named or not fleets)
    away = round(UNIT * CARRIED["away"]) if fleets else 0
    side = CARRIED["side"] if fleets or is_body else ITEM["side"]
    digits = len(str(len(fleets[0].battery) - 1)) if fleets else 1

    def draw_item(age: int | None) -> str:
        return "" if age is None else _item(away, -away, side, ORDERS[age])

    def draw_name(look: str) -> str:
        is_loaded = look == "loaded"
        name = str(robot) if fleets else ROBOT_LOADED if is_loaded else ROBOT_EMPTY
        return _name(name, digits, "dark" if is_loaded else "light")

    if is_body:
        parts = [*_arrows(poses, beat), _machine(track, looks, poses, beat)]
    else:
        parts = [*beat.each(looks, lambda look: f'<circle r="{RADIUS}" class="{look} of-rim"/>')]
    parts += beat.each(items, draw_item)
    if is_named if fleets else not is_body:
        parts += beat.each(looks, draw_name)
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


def _name(text: str, digits: int, look: str) -> str:
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


def _orders(waiting: Iterable[Waiting]) -> Iterator[str]:
    """Yield the number of orders that wait at each pickup, in the colour of the oldest one."""
    half = round(UNIT * ITEM["side"] / 2)
    for (x, y), count, age in waiting:
        col, row = (round(UNIT * (int(place) + ITEM["place"])) for place in (x, y))
        words, look = (f"{count}!", "light") if age == LATE else (str(count), "dark")
        size = 1.6 * half if len(words) == 1 else 2.4 * half / len(words)
        ground = box(col - half, row - half, 2 * half, 2 * half, f"{ORDERS[age]} of-rim")
        at = f'x="{col}" y="{row + 0.36 * size:.0f}" font-size="{size:.0f}"'
        yield f'{ground}<text {at} class="{look}">{words}</text>'


def _burst(hit: DrawnHit) -> str:
    """Return a hit with its label; equal hits of several robots are shown once."""
    x, y = (round(UNIT * place) for place in hit.at)
    star = shape("hit", "hit of-rim", f'transform="translate({x} {y}) scale({hit.size:.3g})"')
    at = f'x="{x}" y="{y - LABEL * hit.size:.0f}" font-size="{LABEL}"'
    words = f'<text {at} class="light of-dark">{html.escape(hit.label)}</text>'
    return star + words if hit.label else star


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


def _lines(frame: Frame) -> Iterator[str]:
    """Yield the outlines of things, planned paths, and an arrow where a robot pushes another.

    There are no rays, because a drawing with all of them would be several times as large.
    """
    if frame.route:
        yield _path(frame.route, "plan dots")
    width = UNIT * LOOK["lines"]["outline"]
    outlines = [f"M{_places([at])}L{_places([to])}" for is_ray, at, to in frame.lines if not is_ray]
    if outlines:
        yield f'<path d="{"".join(outlines)}" class="of-ink" stroke-width="{width:g}"/>'
    paths, wishes, pushers = frame.fleet.plans if frame.fleet else NO_PLANS
    for plans, look in ((paths, "plan"), (wishes, "plan dots")):
        for cells in plans.values():
            yield _path(map(middle, cells), look)
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


def _traces(track: Track, frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the visited cells, trail and items of a robot, and a shadow on what it cannot see."""
    history, rows = History(), frames[0].tiles
    history.read(frames)
    for (row, col), entries in history.entries(len(frames)).items():
        tint = box(UNIT * col, UNIT * row, UNIT, UNIT, "visited")
        for first in entries[1:MAX_VISITS]:
            yield beat.shown_from(tint, first)
    poses = [frame.robots[0] for frame in frames]
    yield from _trail(poses, beat)
    if not history.starts_loaded:
        waits = [(0, history.taken[0] if history.taken else beat.frames)]
        for cell in cells_of(PICKUP, rows):
            yield beat.shown(_item_in(cell), waits)
    for frame, cell in history.delivered:
        yield beat.shown_from(_item_in(cell), frame)
    if track.view_radius is not None and None not in poses:
        first, side = -UNIT * track.view_radius, UNIT * (2 * track.view_radius + 1)
        far = UNIT * 2 * max(len(rows), len(rows[0]))
        window = f"M{-far}-{far}H{far}V{far}H{-far}zM{first} {first}v{side}h{side}v-{side}z"
        cells = [(UNIT * int(p.at[0]), UNIT * int(p.at[1])) for p in poses if p is not None]
        jumps = beat._replace(glides=False)
        yield jumps.moving(f'<path d="{window}" class="shadow"/>', cells)


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
