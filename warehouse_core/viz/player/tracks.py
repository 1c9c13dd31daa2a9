"""What a page says of tracks, as a JSON value with columns; ``player/decode.js`` reads it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from warehouse_core.orders.order import Order
from warehouse_core.render.palette import hex_color
from warehouse_core.viz.player.charts import packed_charts
from warehouse_core.viz.player.columns import Columns
from warehouse_core.viz.tracks.track import Frame, Track
from warehouse_core.world.tiles import Cell

FINE, HALF = 1 / 1024, 1 / 2
"""Units of places, in cells: of continuous tracks, and of others, whose robots are in cells."""

TURN, NO_HEADING = 120, 127
"""Parts of a whole turn, and the sign of an unknown heading."""

NOT_SHOWN, EMPTY = -1, 0
"""Loads of robots; a loaded one has 1 plus the age of its order."""

MILLI = 1e-3

DEFAULT_SPEED = 4.0
"""Simulated seconds in a second; a step of the grid takes a second."""

MAX_SECONDS, MIN_SECONDS = 30.0, 6.0
"""Most seconds in which a search is shown at the default speed; least for slow motion."""

MAX_TEXT = 1_000
"""Characters of a title, a caption or a label; a longer one is cut."""


def packed(tracks: Sequence[Track], title: str, speed: float, opens_at: float | None = None) -> str:
    """Return everything that a page says of tracks, as text; without ``opens_at`` it opens playing.

    Raises:
        ValueError: a place is not finite.
    """
    columns = Columns()
    times = [_times(track) for track in tracks]
    end = max(moments[-1] for moments in times)
    is_search = any(track.marks for track in tracks)
    rate = max(1.0, end / (MAX_SECONDS * DEFAULT_SPEED)) if is_search else 1.0
    page = {
        "title": title,
        "speed": min(DEFAULT_SPEED, end / MIN_SECONDS or 1.0) * speed,
        "rate": rate,
        "opensAt": opens_at,
        "unit": "expansion" if is_search else "step",
        "tracks": [
            _packed_track(track, moments, columns)
            for track, moments in zip(tracks, times, strict=True)
        ],
        "charts": packed_charts(tracks, times, columns),
    }
    return columns.packed(page)


def _times(track: Track) -> list[float]:
    """Return the time of each frame in seconds; a step of the grid takes one."""
    if track.frames[-1].clock:
        return [frame.clock for frame in track.frames]
    return [frame.progress for frame in track.frames]


def _packed_track(track: Track, times: Sequence[float], columns: Columns) -> dict[str, Any]:
    frames = track.frames
    rows = frames[0].tiles
    first = frames[0].fleet
    bodies = max(len(frame.robots) for frame in frames)
    robots = bodies if first is None else len(first.battery)
    tiles, tile_at = _indexed("".join(frame.tiles) for frame in frames)
    energy = any(frame.energy for frame in frames)
    captions, caption_at = _indexed(_cut(frame.caption) for frame in frames)
    return {
        "title": _cut(track.title),
        "ending": _cut(track.ending),
        "isContinuous": track.is_continuous,
        "isFleet": track.is_fleet,
        "width": len(rows[0]),
        "height": len(rows),
        "robots": robots,
        "bodies": bodies,
        "tiles": tiles,
        "tileAt": columns.whole(tile_at, is_delta=True),
        "captions": captions,
        "tellsNext": track.tells_next,
        "captionAt": columns.whole(caption_at, is_delta=True),
        "time": columns.whole(times, is_delta=True, unit=MILLI),
        "progress": columns.real([frame.progress for frame in frames]),
        **_poses(track, bodies, columns),
        "hits": _hits(frames, columns),
        "route": _routes(frames, columns),
        "energy": columns.real([frame.energy for frame in frames] if energy else []),
        "battery": columns.real(track.metrics.get("battery", [])),
        "fullBattery": track.full_battery,
        "viewRadius": track.view_radius,
        "slippery": [list(cell) for cell in track.slippery],
        "motorStrength": track.motor_strength,
        "fleet": None if first is None else _fleet(track, robots, columns),
        "marks": None if track.marks is None else _marks(track, columns),
    }


def _poses(track: Track, bodies: int, columns: Columns) -> dict[str, Any]:
    """Return place, heading and load of each body in each frame, one body after the other."""
    shape = len(track.frames), bodies
    places, angles, loads = np.zeros((*shape, 2)), np.full(shape, np.nan), np.full(shape, NOT_SHOWN)
    for index, frame in enumerate(track.frames):
        here = [body for body, pose in enumerate(frame.robots) if pose is not None]
        poses = [pose for pose in frame.robots if pose is not None]
        if poses:
            places[index, here] = [pose.at for pose in poses]
            loads[index, here] = [pose.loaded for pose in poses]
            angles[index, here] = [pose.heading for pose in poses]  # None becomes NaN
        if frame.fleet is not None:
            ages = np.array(frame.fleet.items, np.float64)  # as here
            loads[index, : len(ages)] = np.where(np.isnan(ages), EMPTY, 1 + ages)
    headings = np.where(np.isnan(angles), NO_HEADING, np.rint(angles / (2 * np.pi) * TURN) % TURN)
    unit = FINE if track.is_continuous else HALF
    return {
        "x": columns.whole(places[..., 0].T, is_delta=True, unit=unit),
        "y": columns.whole(places[..., 1].T, is_delta=True, unit=unit),
        "heading": columns.whole(headings.T),
        "load": columns.whole(loads.T),
    }


def _hits(frames: Sequence[Frame], columns: Columns) -> dict[str, Any]:
    found = [(index, hit) for index, frame in enumerate(frames) for hit in frame.hits]
    labels, label_at = _indexed(_cut(hit.label) for _, hit in found)
    return {
        "frame": columns.whole([index for index, _ in found], is_delta=True),
        "x": columns.whole([hit.at[0] for _, hit in found], unit=FINE),
        "y": columns.whole([hit.at[1] for _, hit in found], unit=FINE),
        "robot": columns.whole([hit.robot for _, hit in found]),
        "labels": labels,
        "labelAt": columns.whole(label_at),
    }


def _routes(frames: Sequence[Frame], columns: Columns) -> dict[str, Any] | None:
    points = [point for frame in frames for point in frame.route]
    if not points:
        return None
    return {
        "count": columns.whole([len(frame.route) for frame in frames]),
        "x": columns.whole([x for x, _ in points], is_delta=True, unit=FINE),
        "y": columns.whole([y for _, y in points], is_delta=True, unit=FINE),
    }


def _marks(track: Track, columns: Columns) -> dict[str, Any]:
    marks = track.marks
    assert marks is not None, "only tracks of searches have them"
    return {
        "time": columns.whole(marks.times, is_delta=True),
        "cell": columns.whole(_numbers(marks.cells, track), is_delta=True),
        "value": columns.whole(marks.values),
        "colors": [hex_color(color) for color in marks.colors],
        "names": [_cut(name) for name in marks.names],
        "ends": [list(cell) for cell in marks.ends],
    }


def _fleet(track: Track, robots: int, columns: Columns) -> dict[str, Any]:
    fleets = [frame.fleet for frame in track.frames if frame.fleet is not None]
    battery = np.array([fleet.battery for fleet in fleets]).reshape(-1, robots)
    ways: list[Cell] = []
    lines: list[tuple[int, int, int, int]] = []
    pushes: list[tuple[int, int, int]] = []
    for index, fleet in enumerate(fleets):
        for kind, found in enumerate((fleet.plans.ways, fleet.plans.wishes)):
            for robot, way in found.items():
                lines.append((index, robot, kind, len(way)))
                ways += way
        pushes += [(index, robot, pusher) for robot, pusher in fleet.plans.pushers.items()]
    return {
        "battery": columns.whole(battery.T, is_delta=True, unit=MILLI),
        "plans": columns.whole(np.array(lines, np.int64).reshape(-1, 4).T, is_delta=True),
        "ways": columns.whole(_numbers(ways, track), is_delta=True),
        "pushes": columns.whole(np.array(pushes, np.int64).reshape(-1, 3).T, is_delta=True),
        "heldUp": {
            "step": columns.whole([step for step, _ in track.held_up], is_delta=True),
            "cell": columns.whole(_numbers([cell for _, cell in track.held_up], track)),
        },
        **({} if track.orders is None else _orders(track, track.orders, columns)),
    }


def _orders(track: Track, orders: Sequence[Order], columns: Columns) -> dict[str, Any]:
    fields = {
        "released": [order.released for order in orders],
        "due": [order.due for order in orders],
        "taken": [_or_never(order.taken) for order in orders],
        "takenBy": [_or_never(order.taken_by) for order in orders],
        "delivered": [_or_never(order.delivered) for order in orders],
        "pickup": _numbers([order.pickup for order in orders], track),
        "dropoff": _numbers([order.dropoff for order in orders], track),
    }
    assigned = [(step, robot, _or_never(order)) for step, robot, order in track.assignments]
    return {
        "orders": {name: columns.whole(values, is_delta=True) for name, values in fields.items()},
        "assigned": columns.whole(np.array(assigned, np.int64).reshape(-1, 3).T, is_delta=True),
    }


def _or_never(value: int | None) -> int:
    return -1 if value is None else value


def _numbers(cells: Iterable[Cell], track: Track) -> list[int]:
    """Return cells as ``row * W + col``."""
    width = len(track.frames[0].tiles[0])
    return [row * width + col for row, col in cells]


def _cut(text: str) -> str:
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}\N{HORIZONTAL ELLIPSIS}"


def _indexed(texts: Iterable[str]) -> tuple[list[str], list[int]]:
    """Return the different ones of some texts, and the index of each."""
    number: dict[str, int] = {}
    places = [number.setdefault(text, len(number)) for text in texts]
    return list(number), places
