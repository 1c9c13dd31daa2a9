"""The signs of a legend, which explain only what occurs in the pictures of a track."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import LOOK, hex_color
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import Pose, Track
from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    WALL,
)

WORDS: dict[str, str] = LOOK["words"]

ORDER = "order-"
"""Prefix of the names of signs of orders, before their age."""

Sign = tuple[str, str]
"""Name of a sign, which determines its look, and its label."""


def signs_of(track: Track) -> list[Sign]:
    """Return the signs of everything that occurs in any frame of a track.

    The name of a sign is a key of the words in ``tiles.json``, ``ORDER`` and the age of an order,
    or a colour of a search.
    """
    return [*_robots(track), *_tiles(track), *_events(track)]


def look_of(name: str) -> tuple[str, str, str]:
    """Return the look of a sign: its style on a page, its colour, and its shape in ``tiles.json``.

    The colour is a name of the palette, or ``#rrggbb``. Signs without an own look are squares.
    """
    style, color, *shape = LOOK["signs"].get(name, ("square", name))
    return style, color, "".join(shape)


def _robots(track: Track) -> Iterator[Sign]:
    """Yield the signs of robots, people, items, batteries, plans and trails."""
    poses = [pose for frame in track.frames for pose in frame.robots if pose is not None]
    loads = {pose.loaded for pose in poses}
    if track.is_continuous:
        pushes = [pose.push for pose in poses if pose.push]
        yield from _named(
            chassis=False in loads,
            chassis_loaded=True in loads,
            velocity=any(any(push.velocity) for push in pushes),
            force=any(any(push.force) for push in pushes),
            brake=any(push.brakes for push in pushes),
            skid=any(push.skids for push in pushes),
        )
    else:
        for letter, is_loaded in ((ROBOT_EMPTY, False), (ROBOT_LOADED, True)):
            if is_loaded in loads:
                yield (letter, WORDS[letter]) if track.is_fleet else _with_letter(letter)
    if not track.is_fleet:
        yield from _traces(track, poses)
        return
    fleets = [frame.fleet for frame in track.frames if frame.fleet]
    ages = {each.age for fleet in fleets for each in fleet.waiting}
    ages |= {age for fleet in fleets for age in fleet.items if age is not None}
    lowest = min(min(fleet.battery) for fleet in fleets)
    if len(track.frames[0].robots) > len(fleets[0].battery):
        yield PERSON, WORDS[PERSON]
    for age in sorted(ages):
        yield f"{ORDER}{age}", f"order, {LOOK['ages'][age]}"
    plans = [fleet.plans for fleet in fleets]
    yield from _named(
        low=lowest < LOOK["battery"]["low"],
        stranded=lowest <= 0,
        plans=any(each.paths for each in plans),
        wishes=any(each.wishes for each in plans),
        pushes=any(each.pushers for each in plans),
    )


def _traces(track: Track, poses: Sequence[Pose]) -> Iterator[Sign]:
    """Yield the signs of items, and of the trail and view of a single robot."""
    frames, history = track.frames, History()
    history.read(frames if poses else ())
    moves = {before.loaded for before, after in pairwise(poses) if before.at != after.at}
    has_pickup = any(PICKUP in line for line in frames[0].tiles) and track.marks is None
    yield from _named(
        item=any(pose.loaded for pose in poses) or has_pickup,
        shadow=track.view_radius is not None and bool(poses),
        visited=any(len(each) > 1 for each in history.entries(track.steps).values()),
        trail=False in moves,
        trail_loaded=True in moves,
    )


def _tiles(track: Track) -> Iterator[Sign]:
    """Yield the signs of tiles and slippery floor. A search has no signs of stations."""
    all_rows = {frame.tiles for frame in track.frames}
    tiles = {tile for rows in all_rows for line in rows for tile in line}
    for tile in (PICKUP, DROPOFF, CHARGER):
        if tile in tiles and track.marks is None:
            yield _with_letter(tile)
    on_border = {
        row in (0, len(rows) - 1) or col in (0, len(rows[0]) - 1)
        for rows in all_rows
        for row, line in enumerate(rows)
        for col, tile in enumerate(line)
        if tile == WALL
    }
    slippery = {
        rows[row][col]
        for rows in all_rows
        for row, col in track.slippery
        if 0 <= row < len(rows) and 0 <= col < len(rows[0])
    }
    yield from _named(
        shelf=False in on_border,
        wall=True in on_border,
        unseen=UNSEEN in tiles,
        ice=bool(slippery - {WALL, UNSEEN}),
    )


def _events(track: Track) -> Iterator[Sign]:
    """Yield the signs of hits, lines, a planned path, and a search with its path."""
    seen = {is_ray for frame in track.frames for is_ray, _, _ in frame.lines}
    yield from _named(
        ghost=bool(track.ghost),
        hit=any(frame.hits for frame in track.frames),
        plan=track.marks is None and any(frame.route for frame in track.frames),
        ray=True in seen,
        outline=False in seen,
    )
    if track.marks is not None:
        for color, name in zip(track.marks.colors, track.marks.names, strict=True):
            yield hex_color(color), name
        has_path = any(frame.route for frame in track.frames)
        yield from _named(path=has_path, ends=True)


def _with_letter(letter: str) -> Sign:
    return letter, f"{letter} {WORDS[letter]}"


def _named(**are_shown: bool) -> Iterator[Sign]:
    """Yield the signs whose names have the value ``True``."""
    for name, is_shown in are_shown.items():
        if is_shown:
            key = name.replace("_", "-")
            yield key, WORDS[key]
