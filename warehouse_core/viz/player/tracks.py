"""The data of a page: a JSON value that describes its tracks, and a block of bytes for its arrays.

The JSON value refers to arrays by ``{"$": [kind, offset, length, is_delta, unit]}``. ``kind`` is
the type of the stored numbers (``i1``, ``i2``, ``i4`` or ``f4``, little-endian), and ``offset``
counts bytes. With ``is_delta`` each number is stored as its difference from the previous one. The
stored numbers count multiples of ``unit``. ``player/track.js`` reads this format.
"""

from __future__ import annotations

import json
import struct
import zlib
from base64 import b64encode
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.render.palette import hex_color
from warehouse_core.viz.tracks.series import series_of
from warehouse_core.viz.tracks.signs import look_of, signs_of
from warehouse_core.viz.tracks.track import Frame, Marks, Track
from warehouse_core.world.tiles import Cell

ALIGNMENT = 4
LEVEL = 6
"""Compression level. The highest level takes ten times as long and makes pages 7% smaller."""

KINDS = {"i1": 2**7, "i2": 2**15, "i4": 2**31}
"""Types of whole numbers, and the exclusive limits on their absolute values."""

FINE, HALF, MILLI, SPEED = 1 / 1024, 1 / 2, 1e-3, 0.01
"""Units of stored numbers: positions of continuous tracks in cells, positions of other tracks in
cells, whose robots are at centres of cells, times and battery levels, and speeds in m/s."""

TURN, NO_HEADING = 120, 127
"""Number of parts of a whole turn, and the number that stands for an unknown heading."""

NOT_SHOWN, EMPTY = -1, 0
"""Loads of robots that are not shown or not loaded. A loaded robot has 1 plus the age of its
order."""

DEFAULT_SPEED = 4.0
"""Simulated seconds shown per second; a step of the grid backend counts as one second."""

MAX_SECONDS, MIN_SECONDS = 30.0, 6.0
"""Longest duration of a search, and shortest duration of any replay, at the default speed."""

MAX_TRACKS = 4
"""Most tracks of a page with charts, which is the number of line styles in ``charts.js``."""

MAX_TEXT = 1_000
"""Most characters of a title, a caption or a label; longer ones are truncated."""

Reference = dict[str, list[Any]]


class Columns:
    """A collection of arrays, which are packed after a JSON value that refers to them.

    Equal arrays, such as the times of several charts, are stored once.
    """

    def __init__(self) -> None:
        self._parts: dict[bytes, int] = {}
        self._length = 0

    def whole(self, values: ArrayLike, *, is_delta: bool = False, unit: float = 1) -> Reference:
        """Add numbers, rounded to multiples of ``unit``, and return a reference to them.

        Raises:
            ValueError: a number is not finite, or too large for 32 bits.
        """
        stored = np.rint(np.asarray(values, np.float64).ravel() / unit)
        largest = _largest(stored)
        if is_delta:
            stored = np.diff(stored, prepend=0)
            largest = _largest(stored)
        kind = next(name for name, limit in KINDS.items() if largest < limit)
        return self._add(kind, stored.astype(f"<{kind}"), is_delta=is_delta, unit=unit)

    def real(self, values: ArrayLike) -> Reference:
        """Add numbers in single precision, possibly NaN, and return a reference to them."""
        return self._add("f4", np.asarray(values, "<f4").ravel(), is_delta=False, unit=1)

    def table(
        self, names: str, rows: Sequence[Sequence[float | None]], unit: float = 1
    ) -> dict[str, Reference]:
        """Add rows of numbers, and return a reference to each column by name.

        ``names`` has the names of the columns, separated by spaces. ``None`` is stored as -1.
        """
        columns = [*zip(*rows, strict=True)] or [()] * len(names.split())
        return {
            name: self.whole(
                [-1 if value is None else value for value in column], is_delta=True, unit=unit
            )
            for name, column in zip(names.split(), columns, strict=True)
        }

    def packed(self, value: Any) -> str:
        """Return a JSON value and all columns, compressed, as base64."""
        text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        words = text.encode("utf-8", "backslashreplace")
        words += b" " * (-len(words) % ALIGNMENT)
        block = b"".join([struct.pack("<I", len(words)), words, *self._parts])
        return b64encode(zlib.compress(block, LEVEL)).decode("ascii")

    def _add(self, kind: str, stored: Any, *, is_delta: bool, unit: float) -> Reference:
        data = stored.tobytes()
        data += b"\0" * (-len(data) % ALIGNMENT)
        if data not in self._parts:
            self._parts[data] = self._length
            self._length += len(data)
        return {"$": [kind, self._parts[data], len(stored), int(is_delta), unit]}


def _largest(numbers: NDArray[np.float64]) -> float:
    """Return the largest absolute value, or 0 without numbers; raise if it needs over 32 bits."""
    largest = float(np.abs(numbers).max(initial=0))
    if not largest < KINDS["i4"]:
        raise ValueError("a number of a page is not finite, or too large for 32 bits")
    return largest


def packed(tracks: Sequence[Track], title: str, speed: float, opens_at: float | None = None) -> str:
    """Return the data of a page as text. Without ``opens_at`` the page plays when it opens.

    Raises:
        ValueError: a position is not finite.
    """
    columns = Columns()
    times = [_times(track) for track in tracks]
    end = max(moments[-1] for moments in times)
    is_search = any(track.marks for track in tracks)
    pairs = [*zip(tracks, times, strict=True)]
    signs = (sign for track in tracks for sign in signs_of(track))
    page = {
        "title": title,
        "speed": min(DEFAULT_SPEED, end / MIN_SECONDS or 1.0) * speed,
        "rate": max(1.0, end / (MAX_SECONDS * DEFAULT_SPEED)) if is_search else 1.0,
        "opensAt": opens_at,
        "unit": "expansion" if is_search else "step",
        "tracks": [_track(track, moments, columns) for track, moments in pairs],
        "legend": [(words, *look_of(name)) for name, words in dict.fromkeys(signs)],
        "charts": _charts(pairs, columns) if len(tracks) <= MAX_TRACKS else [],
    }
    return columns.packed(page)


def _times(track: Track) -> list[float]:
    """Return the time of each frame in seconds; a step of the grid backend takes one second."""
    if track.frames[-1].clock:
        return [frame.clock for frame in track.frames]
    return [frame.progress for frame in track.frames]


def _charts(pairs: Sequence[tuple[Track, Sequence[float]]], columns: Columns) -> list[Any]:
    """Return the charts of tracks with their times. Series with the same title share a chart."""
    charts: dict[str, list[dict[str, Any]]] = {}
    for number, (track, times) in enumerate(pairs):
        for series in series_of(track, times):
            if len(pairs) > 1 and (series.kind == "bars" or not len(series.times)):
                continue  # bars of several tracks would hide each other
            charts.setdefault(series.chart, []).append(
                {
                    "track": number,
                    "name": series.name,
                    "kind": series.kind,
                    "color": series.color,
                    "steps": series.steps,
                    "x": columns.real(series.times),
                    "y": columns.real(series.values),
                }
            )
    return [{"title": title, "series": series} for title, series in charts.items()]


def _track(track: Track, times: Sequence[float], columns: Columns) -> dict[str, Any]:
    frames = track.frames
    rows, first = frames[0].tiles, frames[0].fleet
    bodies = max(len(frame.robots) for frame in frames)
    tiles, tile_at = _indexed("".join(frame.tiles) for frame in frames)
    captions, caption_at = _indexed(_cut(frame.caption) for frame in frames)
    route = [(index, *point) for index, frame in enumerate(frames) for point in frame.route]
    return {
        "title": _cut(track.title),
        "ending": _cut(track.ending),
        "isContinuous": track.is_continuous,
        "isMeasured": track.is_measured,
        "isFleet": track.is_fleet,
        "width": len(rows[0]),
        "height": len(rows),
        "outer": track.outer,
        "robots": bodies if first is None else len(first.battery),
        "bodies": bodies,
        "tiles": tiles,
        "tileAt": columns.whole(tile_at, is_delta=True),
        "captions": captions,
        "captionsNext": track.captions_next,
        "captionAt": columns.whole(caption_at, is_delta=True),
        "time": columns.whole(times, is_delta=True, unit=MILLI),
        "progress": columns.real([frame.progress for frame in frames]),
        **_poses(track, bodies, columns),
        "ghost": columns.table("x y", track.ghost, FINE),
        "hits": _hits(frames, columns),
        "route": columns.table("frame x y", route, FINE),
        **_lines(frames, columns),
        "energy": columns.real([frame.energy for frame in frames] if track.is_measured else []),
        "battery": columns.real(track.metrics.get("battery", [])),
        "fullBattery": track.full_battery,
        "viewRadius": track.view_radius,
        "slippery": [list(cell) for cell in track.slippery],
        "motorStrength": track.motor_strength,
        "drive": track.drive,
        "fleet": None if first is None else _fleet(track, len(first.battery), columns),
        "marks": None if track.marks is None else _marks(track.marks, len(rows[0]), columns),
    }


def _poses(track: Track, bodies: int, columns: Columns) -> dict[str, Any]:
    """Return the position, heading and load of each body in all frames, body after body."""
    shape = len(track.frames), bodies
    places, angles, loads = np.zeros((*shape, 2)), np.full(shape, np.nan), np.full(shape, NOT_SHOWN)
    pushes, skids = np.zeros((4, *shape)), np.zeros(shape)
    for index, frame in enumerate(track.frames):
        here = [body for body, pose in enumerate(frame.robots) if pose is not None]
        poses = [pose for pose in frame.robots if pose is not None]
        if poses:
            places[index, here] = [pose.at for pose in poses]
            loads[index, here] = [pose.loaded for pose in poses]
            angles[index, here] = [pose.heading for pose in poses]  # None becomes NaN
        for body, pose in zip(here, poses, strict=True):
            if pose.push:
                pushes[:, index, body] = *pose.push.velocity, *pose.push.force
                skids[index, body] = pose.push.skids
        if frame.fleet is not None:
            ages = np.array(frame.fleet.items, np.float64)  # None becomes NaN
            loads[index, : len(ages)] = np.where(np.isnan(ages), EMPTY, 1 + ages)
    headings = np.where(np.isnan(angles), NO_HEADING, np.rint(angles / (2 * np.pi) * TURN) % TURN)
    unit = FINE if track.is_continuous else HALF
    if not pushes.any():
        pushes, skids = pushes[:, :0], skids[:0]
    names = zip(("vx", "vy", "fx", "fy"), pushes, (SPEED, SPEED, 1, 1), strict=True)
    return {
        **{name: columns.whole(values.T, is_delta=True, unit=unit) for name, values, unit in names},
        "skid": columns.whole(skids.T),
        "x": columns.whole(places[..., 0].T, is_delta=True, unit=unit),
        "y": columns.whole(places[..., 1].T, is_delta=True, unit=unit),
        "heading": columns.whole(headings.T),
        "load": columns.whole(loads.T),
    }


def _hits(frames: Sequence[Frame], columns: Columns) -> dict[str, Any]:
    found = [(index, hit) for index, frame in enumerate(frames) for hit in frame.hits]
    labels, label_at = _indexed(_cut(hit.label) for _, hit in found)
    rows = [
        (index, *hit.at, hit.robot, hit.size, label)
        for (index, hit), label in zip(found, label_at, strict=True)
    ]
    return {"labels": labels, **columns.table("frame x y robot size labelAt", rows, FINE)}


def _lines(frames: Sequence[Frame], columns: Columns) -> dict[str, Any]:
    """Return the rays and outlines of all frames, line after line; missing lines have no length."""
    most = max(frames, key=lambda frame: len(frame.lines)).lines
    if not most:
        return {}
    ends = np.zeros((len(frames), len(most), 4))
    for places, frame in zip(ends, frames, strict=True):
        if frame.lines:
            places[: len(frame.lines)] = [(*start, *end) for _, start, end in frame.lines]
    x, y, to_x, to_y = (
        columns.whole(ends[..., axis].T, is_delta=True, unit=FINE) for axis in range(4)
    )
    kinds = [is_ray for is_ray, _, _ in most]
    return {"lines": {"isRay": kinds, "x": x, "y": y, "toX": to_x, "toY": to_y}}


def _marks(marks: Marks, width: int, columns: Columns) -> dict[str, Any]:
    cells = (_number(cell, width) for cell in marks.cells)
    rows = [*zip(marks.times, cells, marks.values, strict=True)]
    return {
        **columns.table("time cell value", rows),
        "colors": [hex_color(color) for color in marks.colors],
        "ends": [list(cell) for cell in marks.ends],
    }


def _fleet(track: Track, robots: int, columns: Columns) -> dict[str, Any]:
    fleets = [frame.fleet for frame in track.frames if frame.fleet is not None]
    width = len(track.frames[0].tiles[0])
    battery = np.array([fleet.battery for fleet in fleets]).reshape(-1, robots)
    paths: list[int] = []
    plans: list[tuple[int, int, int, int]] = []
    pushes: list[tuple[int, int, int]] = []
    for index, fleet in enumerate(fleets):
        for is_wish, planned in enumerate((fleet.plans.paths, fleet.plans.wishes)):
            for robot, path in planned.items():
                paths += [_number(cell, width) for cell in path]
                plans.append((index, robot, is_wish, len(paths)))
        pushes += [(index, robot, pusher) for robot, pusher in fleet.plans.pushers.items()]
    waiting = [
        (step, int(y) * width + int(x), number, age)
        for step, frame in enumerate(track.ends)
        for (x, y), number, age in fleets[frame].waiting
    ]
    held_up = [(step, _number(cell, width)) for step, cell in track.held_up]
    return {
        "battery": columns.whole(battery.T, is_delta=True, unit=MILLI),
        "plans": columns.table("frame robot isWish end", plans),
        "paths": columns.whole(paths, is_delta=True),
        "pushes": columns.table("frame robot pusher", pushes),
        "waiting": columns.table("step cell number age", waiting),
        "heldUp": columns.table("step cell", held_up),
    }


def _number(cell: Cell, width: int) -> int:
    """Return a cell as the number ``row * width + col``."""
    return cell[0] * width + cell[1]


def _cut(text: str) -> str:
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}\N{HORIZONTAL ELLIPSIS}"


def _indexed(texts: Iterable[str]) -> tuple[list[str], list[int]]:
    """Return the distinct texts, and the index of each text among them."""
    number: dict[str, int] = {}
    places = [number.setdefault(text, len(number)) for text in texts]
    return list(number), places
