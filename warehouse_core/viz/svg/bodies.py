"""What moves in an animated drawing: robots and people, items, orders, plans and hits.

All lengths are in hundredths of a cell.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from warehouse_core.viz.svg.change import (
    Beat,
    Span,
    extend,
    growing,
    jumping,
    moving,
    shown,
    spans_of,
    turning,
)
from warehouse_core.viz.svg.floor import UNIT, box
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import Frame, Point, Pose, Track
from warehouse_core.world.tiles import PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED

RADIUS = 34
"""Radius of a robot."""

NOSE = "M48 0 30 16V-16z"
"""Wedge at the rim of a robot that heads east."""

DIAMOND = "M0-34 34 0 0 34-34 0z"

STAR = " ".join(
    f"{reach * math.sin(point * math.pi / 5):.0f},{-reach * math.cos(point * math.pi / 5):.0f}"
    for point, reach in enumerate([26, 12] * 5)
)

ORDERS = ("item", "order-older", "order-nearly-due", "order-late")
"""Colours of orders by their age, by name."""

LATE = len(ORDERS) - 1

FEW, LOW_SHARE = 12, 0.25
"""Robots of the largest fleet that always shows batteries; share below which all others do."""

MIN_NAMED = 20
"""Least pixels of a cell in which the number of a robot is legible."""

NAMES = {"loaded": "dark"}
"""Colours of the numbers on robots by the colours of these; others are light."""

MAX_VISITS = 5
"""Visits of a cell above which its colour stays the same."""


def bodies_of(track: Track, frames: Sequence[Frame], beat: Beat, pixels: float) -> Iterator[str]:
    """Yield everything on the floor in some frames of a track, from the lowest to the highest.

    A cell has so many ``pixels`` a side; where these are few, robots have no names.
    """
    robots = len(frames[0].fleet.battery) if frames[0].fleet else len(frames[0].robots)
    if not track.is_fleet:
        for robot in range(robots):
            yield from _traces(track, frames, robot, beat)
    yield from _lines(frames, beat)
    yield from _orders(frames, beat)
    for body in range(len(frames[0].robots)):
        poses = [frame.robots[body] for frame in frames]
        known = next((pose for pose in poses if pose is not None), None)
        if known is None:
            continue
        places = []
        for pose in poses:
            known = pose or known
            places.append((round(UNIT * known.at[0]), round(UNIT * known.at[1])))
        there = spans_of(pose is not None for pose in poses)[True]
        if body >= robots:
            drawn = f'<path d="{DIAMOND}" class="person of-rim"/>{_name(PERSON, 1, "light")}'
        elif track.is_fleet:
            drawn = _fleet_robot(frames, body, robots, poses, beat, is_named=pixels >= MIN_NAMED)
        else:
            drawn = _lone_robot(poses, beat)
        yield shown(moving(_nose(poses, beat) + drawn, places, beat), there, beat)
    for at, spans in _hits(frames).items():
        x, y = (round(UNIT * place) for place in at)
        star = f'<polygon points="{STAR}" transform="translate({x} {y})" class="hit of-rim"/>'
        yield shown(star, spans, beat)


def _nose(poses: Sequence[Pose | None], beat: Beat) -> str:
    """Return the nose of a body, which is shown once the body has a heading."""
    headings = [None if pose is None else pose.heading for pose in poses]
    known = next((heading for heading in headings if heading is not None), None)
    if known is None:
        return ""
    angles = []
    for heading in headings:
        known = known if heading is None else heading
        angles.append(known)
    degrees = np.degrees(np.unwrap(angles)).round().astype(int).tolist()
    has_one = spans_of(heading is not None for heading in headings)[True]
    return shown(turning(f'<path d="{NOSE}" class="rim"/>', degrees, beat), has_one, beat)


def _lone_robot(poses: Sequence[Pose | None], beat: Beat) -> str:
    is_loaded = spans_of(pose is not None and pose.loaded for pose in poses)
    empty = _disc("robot") + _name(ROBOT_EMPTY, 1, "light")
    loaded = _disc("loaded") + item(0, 0, 40, "item") + _name(ROBOT_LOADED, 1, "dark")
    return shown(empty, is_loaded.get(False, []), beat) + shown(
        loaded, is_loaded.get(True, []), beat
    )


def _fleet_robot(
    frames: Sequence[Frame],
    robot: int,
    robots: int,
    poses: Sequence[Pose | None],
    beat: Beat,
    *,
    is_named: bool,
) -> str:
    """Return a robot with its number, its battery if that is low, and the item of its order."""
    fleets = [frame.fleet for frame in frames if frame.fleet is not None]
    levels = [fleet.battery[robot] for fleet in fleets]
    name, digits = str(robot) if is_named else "", len(str(robots - 1))
    looks = spans_of(
        "stranded" if level <= 0 else "loaded" if pose is not None and pose.loaded else "robot"
        for level, pose in zip(levels, poses, strict=True)
    )
    parts = [
        shown(_disc(look) + _name(name, digits, NAMES.get(look, "light")), spans, beat)
        for look, spans in looks.items()
    ]
    ages = spans_of(fleet.items[robot] for fleet in fleets)
    parts += [
        shown(item(26, -26, 28, ORDERS[age]), spans, beat)
        for age, spans in ages.items()
        if age is not None
    ]
    is_low = spans_of(level < LOW_SHARE for level in levels)
    width, animation = growing("width", [round(68 * level) for level in levels], beat)
    for low, look in ((False, "battery"), (True, "warning")):
        if low or robots <= FEW:
            bar = f'<rect x="-34" y="28" height="9" {width} class="{look}">{animation}</rect>'
            ground = box(-35, 27, 70, 11, "light of-rim")
            parts.append(shown(ground + bar, is_low.get(low, []), beat))
    return "".join(parts)


def _disc(look: str) -> str:
    return f'<circle r="{RADIUS}" class="{look} of-rim"/>'


def _name(text: str, digits: int, look: str) -> str:
    if not text:
        return ""
    size = round(RADIUS * min(1.1, 2 / digits))
    rim = " of-dark" if look == "light" else ""
    return f'<text y="{0.36 * size:.0f}" font-size="{size}" class="{look}{rim}">{text}</text>'


def item(x: int, y: int, side: int, look: str) -> str:
    """Return a box around its middle, with a strip of tape."""
    half = side // 2
    tape = f'<path d="M{x} {y - half}v{round(0.4 * side)}" class="of-dark" stroke-width="4"/>'
    return box(x - half, y - half, side, side, f"{look} of-rim") + tape


def _orders(frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield how many orders wait at each pickup, in the colours of their ages."""
    waiting: dict[Point, list[tuple[int, int] | None]] = {}
    for number, frame in enumerate(frames):
        for at, count, age in frame.fleet.waiting if frame.fleet else ():
            waiting.setdefault(at, [None] * len(frames))[number] = count, age
    for (x, y), states in waiting.items():
        left, top = round(UNIT * x) + 17, round(UNIT * y) + 15
        for state, spans in spans_of(states).items():
            if state is not None:
                count, age = state
                words = f"{count}{'!' * (age == LATE)}"
                look = "light" if age == LATE else "dark"
                size = 40 if len(words) < 3 else 28
                text = f'<text x="{left}" y="{top + 14}" font-size="{size}" class="{look}">'
                inner = box(left - 27, top - 25, 54, 50, f"{ORDERS[age]} of-rim")
                yield shown(f"{inner}{text}{words}</text>", spans, beat)


def _hits(frames: Sequence[Frame]) -> dict[Point, list[Span]]:
    """Return the spans of the hits at each place."""
    found: dict[Point, list[Span]] = {}
    for number, frame in enumerate(frames):
        for at in {hit.at for hit in frame.hits}:
            extend(found.setdefault(at, []), number, number + 1)
    return found


def _lines(frames: Sequence[Frame], beat: Beat) -> Iterator[str]:
    """Yield the planned ways of robots, and who pushes whom."""
    for route, spans in spans_of(frame.route for frame in frames).items():
        if route:
            yield shown(_way(route, "plan dots"), spans, beat)
    drawn: dict[str, list[bool]] = {}
    for number, frame in enumerate(frames):
        for line in _plans(frame):
            drawn.setdefault(line, [False] * len(frames))[number] = True
    for line, flags in drawn.items():
        yield shown(line, spans_of(flags)[True], beat)


def _plans(frame: Frame) -> Iterator[str]:
    """Yield the plans of a fleet in a frame."""
    if frame.fleet is None:
        return
    ways, wishes, pushers = frame.fleet.plans
    for cells, look in [(way, "plan") for way in ways.values()] + [
        (wish, "plan dots") for wish in wishes.values()
    ]:
        yield _way([(col + 0.5, row + 0.5) for row, col in cells], look)
    for pushed, pusher in pushers.items():
        (x, y), (right, down) = (
            pose.at for pose in (frame.robots[pusher], frame.robots[pushed]) if pose is not None
        )
        angle = round(math.degrees(math.atan2(down - y, right - x)))
        at = f"{UNIT * (x + right) / 2:.0f} {UNIT * (y + down) / 2:.0f}"
        arrow = f'transform="translate({at}) rotate({angle})"'
        yield f'<path d="M20 0-8 18V-18z" {arrow} class="rim of-light" stroke-width="3"/>'


def _way(points: Sequence[Point], look: str) -> str:
    places = " ".join(f"{UNIT * x:.0f},{UNIT * y:.0f}" for x, y in points)
    return f'<polyline points="{places}" class="{look} of-ink"/>'


def _traces(track: Track, frames: Sequence[Frame], robot: int, beat: Beat) -> Iterator[str]:
    """Yield what a lone robot leaves behind: visits, its trail, items; and what it does not see."""
    history = History(robot)
    history.read(frames)
    yield from _visits(frames, robot, beat)
    yield from _trail(frames, robot, beat)
    waits = [(0, history.taken[0] if history.taken else beat.frames)]
    for row, line in enumerate(frames[0].tiles):
        for col, tile in enumerate(line):
            if tile == PICKUP and not history.starts_loaded:
                yield shown(item(UNIT * col + 73, UNIT * row + 73, 36, "item"), waits, beat)
    for frame, (row, col) in history.delivered:
        box_there = item(UNIT * col + 73, UNIT * row + 73, 36, "item")
        yield shown(box_there, [(frame, beat.frames)], beat)
    poses = [frame.robots[robot] for frame in frames]
    if track.view_radius is not None and len(frames[0].robots) == 1 and None not in poses:
        first, side = -UNIT * track.view_radius, UNIT * (2 * track.view_radius + 1)
        far = UNIT * 2 * max(len(frames[0].tiles), len(frames[0].tiles[0]))
        window = f"M{-far}-{far}H{far}V{far}H{-far}zM{first} {first}v{side}h{side}v-{side}z"
        cells = [(UNIT * int(p.at[0]), UNIT * int(p.at[1])) for p in poses if p is not None]
        yield jumping(f'<path d="{window}" class="shadow"/>', cells, beat)


def _visits(frames: Sequence[Frame], robot: int, beat: Beat) -> Iterator[str]:
    """Yield tints of the cells that a robot has come to more than once."""
    came: dict[tuple[int, int], list[int]] = {}
    before = None
    for number, frame in enumerate(frames):
        pose = frame.robots[robot]
        if pose is None or not frame.progress.is_integer():
            continue
        cell = int(pose.at[1]), int(pose.at[0])
        if cell != before:
            came.setdefault(cell, []).append(number)
        before = cell
    for (row, col), times in came.items():
        for first in times[1:MAX_VISITS]:
            tint = box(UNIT * col, UNIT * row, UNIT, UNIT, "visited")
            yield shown(tint, [(first, beat.frames)], beat)


def _trail(frames: Sequence[Frame], robot: int, beat: Beat) -> Iterator[str]:
    """Yield the way of a robot, which grows behind it, in the colours of its load."""
    poses = [frame.robots[robot] for frame in frames]
    looks = spans_of(pose and ("loaded" if pose.loaded else "robot") for pose in poses)
    pieces = [(look, span) for look, spans in looks.items() if look for span in spans]
    for look, (first, end) in pieces:
        last = min(end, beat.frames - 1)
        ways = [pose.at for pose in poses[first : last + 1] if pose is not None]
        steps = [math.dist(one, other) for one, other in pairwise(ways)]
        gone = np.cumsum([0.0, *steps])
        length = round(UNIT * float(gone[-1]))
        if not length or len(ways) != last + 1 - first:
            continue
        left = length - np.round(UNIT * gone).astype(int)
        offsets = [length] * first + left.tolist() + [0] * (beat.frames - 1 - last)
        offset, animation = growing("stroke-dashoffset", offsets, beat)
        corners = _without_repeats(ways)
        places = " ".join(f"{UNIT * x:.0f},{UNIT * y:.0f}" for x, y in corners)
        yield (
            f'<polyline points="{places}" pathLength="{length}" '
            f'stroke-dasharray="{length} {length}" {offset} class="trail of-{look}">'
            f"{animation}</polyline>"
        )


def _without_repeats(points: Sequence[Point]) -> list[Point]:
    return [points[0], *(now for before, now in pairwise(points) if now != before)]
