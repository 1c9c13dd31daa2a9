"""The legend of a replay: what is in its picture, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from matplotlib.artist import Artist
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.atlas import UNSEEN
from warehouse_core.render.palette import (
    BOARD,
    COLORS,
    HIT,
    ICE,
    ICE_WAVE,
    INK,
    ITEM,
    LOOK,
    ORDER_COLORS,
    PAPER,
    SHADOW,
    SHELF,
    STRANDED,
    TRAIL_COLORS,
    TRAIL_STYLES,
    UNKNOWN,
    UNKNOWN_STRIPE,
    VISITED,
    WARNING,
    Color,
)
from warehouse_core.viz.axes.look import SMALLEST
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import WEAK_MOTOR, cells_of
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    EMPTY,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    WALL,
)

WORDS = LOOK["words"]

DOTTED: dict[str, Any] = {"linestyle": (0, (0.1, 1.6)), "dash_capstyle": "round"}

Signs = dict[str, Artist]


def draw_legend(
    figure: SceneFigure,
    tracks: Sequence[Track],
    columns: int = 0,
    *,
    with_characters: bool = False,
) -> Legend:
    """Draw the legend of what tracks show, in columns along the bottom or one on the right side.

    With characters, it explains them as ``render_with_legend`` does. Return the legend.
    """
    signs: Signs = {}
    for track in tracks:
        signs |= signs_of(track)
    if with_characters:
        signs = {f"{WALL} {WORDS['wall']}" if words == WORDS["wall"] else words: sign
                 for words, sign in signs.items()}  # fmt: skip
        signs[f"{EMPTY} {LEGEND[EMPTY]}"] = _marker("s", COLORS[EMPTY])
    place: dict[str, Any] = {"loc": "center right", "ncols": 1, "labelspacing": 0.7}
    if columns:
        place = {"loc": "lower center", "ncols": columns}
    return figure.legend(
        [*signs.values()], [*signs], fontsize=SMALLEST, frameon=False, handlelength=2.0,
        columnspacing=1.4, handletextpad=0.5, **place,
    )  # fmt: skip


def signs_of(track: Track) -> Signs:
    """Return the signs in any frame of a track, by what they mean."""
    signs: Signs = {}
    frames = track.frames
    poses = [pose for frame in frames for pose in frame.robots if pose is not None]
    for tile, loaded in ((ROBOT_EMPTY, False), (ROBOT_LOADED, True)):
        if any(pose.loaded == loaded for pose in poses):
            signs[_words(tile, has_letter=not track.is_fleet)] = _marker("o", COLORS[tile])
    signs |= _fleet_signs(track) if track.is_fleet else _lone_signs(track)
    signs |= _tile_signs(track)
    if any(frame.hits for frame in frames):
        signs[WORDS["hit"]] = _marker("*", HIT, 11)
    if any(frame.route for frame in frames):
        signs[WORDS["plan"]] = Line2D([], [], color=INK, lw=2.6, **DOTTED)
    if track.motor_strength < 1:
        dashed: dict[str, Any] = {"linestyle": (0, WEAK_MOTOR), "lw": 1.4}
        signs[f"motors at {track.motor_strength:.0%}"] = _patch(PAPER, edgecolor=INK, **dashed)
    return signs


def _words(tile: str, *, has_letter: bool = True) -> str:
    """Return the words of a tile, after the letter that a picture shows."""
    return f"{tile} {WORDS[tile]}" if has_letter else str(WORDS[tile])


def _tile_signs(track: Track) -> Signs:
    signs: Signs = {}
    all_rows = {frame.tiles for frame in track.frames}
    tiles = {tile for rows in all_rows for line in rows for tile in line}
    for tile in (PICKUP, DROPOFF, CHARGER):
        if tile in tiles:
            signs[_words(tile)] = _marker("s", COLORS[tile])
    on_border = {
        any(at in (0, end - 1) for at, end in ((row, len(rows)), (col, len(rows[0]))))
        for rows in all_rows
        for row, col in cells_of(WALL, rows)
    }
    if False in on_border:
        signs[WORDS["shelf"]] = _patch(SHELF, edgecolor=BOARD, hatch="--", lw=0)
    if True in on_border:
        signs[WORDS["wall"]] = _marker("s", COLORS[WALL])
    if UNSEEN in tiles:
        signs[WORDS["unseen"]] = _patch(UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="///", lw=0)
    if any(
        0 <= row < len(rows) and 0 <= col < len(rows[0]) and rows[row][col] not in (WALL, UNSEEN)
        for rows in all_rows
        for row, col in track.slippery
    ):
        signs[WORDS["ice"]] = _patch(ICE, edgecolor=ICE_WAVE, hatch="\\\\\\", lw=0)
    return signs


def _lone_signs(track: Track) -> Signs:
    """Return the signs of items, trails and the view of robots that are no fleet."""
    signs: Signs = {}
    frames = track.frames
    histories = [History(robot) for robot in range(len(frames[0].robots))]
    for history in histories:
        history.read(frames)
    is_loaded = any(pose and pose.loaded for frame in frames for pose in frame.robots)
    if is_loaded or any(PICKUP in line for line in frames[0].tiles):
        signs[WORDS["item"]] = _marker("s", ITEM, 8)
    if track.view_radius is not None and len(histories) == 1:
        signs[WORDS["shadow"]] = _patch(INK, alpha=SHADOW, lw=0)
    if any(max(history.visits(track.steps).values(), default=0) > 1 for history in histories):
        signs[WORDS["visited"]] = _patch(VISITED[-1], lw=0)
    moves = {
        before.loaded
        for first, second in pairwise(frames)
        for before, after in zip(first.robots, second.robots, strict=True)
        if before and after and before.at != after.at
    }
    for loaded in sorted(moves):
        style: dict[str, Any] = {"color": TRAIL_COLORS[loaded], "linestyle": TRAIL_STYLES[loaded]}
        signs[WORDS["trail-loaded" if loaded else "trail"]] = Line2D([], [], lw=2.2, **style)
    return signs


def _fleet_signs(track: Track) -> Signs:
    """Return the signs of people, orders, batteries and plans."""
    fleets = [frame.fleet for frame in track.frames if frame.fleet]
    ages = {each.age for fleet in fleets for each in fleet.waiting}
    ages |= {age for fleet in fleets for age in fleet.items if age is not None}
    lowest = min((min(fleet.battery) for fleet in fleets), default=1.0)
    signs: Signs = {}
    if len(track.frames[0].robots) > len(fleets[0].battery):
        signs[WORDS[PERSON]] = _marker("D", COLORS[PERSON], 8)
    for age in sorted(ages):
        signs[f"order, {LOOK['ages'][age]}"] = _marker("s", ORDER_COLORS[age], 8)
    if lowest < LOOK["battery"]["low"]:
        signs[WORDS["low"]] = Line2D([], [], color=WARNING, lw=4.0, solid_capstyle="butt")
    if lowest <= 0:
        signs[WORDS["stranded"]] = _marker("o", STRANDED, 8)
    plans = [fleet.plans for fleet in fleets]
    line: dict[str, Any] = {"color": COLORS[ROBOT_EMPTY], "lw": 3.0}
    if any(each.ways for each in plans):
        signs[WORDS["plans"]] = Line2D([], [], **line)
    if any(each.wishes for each in plans):
        signs[WORDS["wishes"]] = Line2D([], [], **line, **DOTTED)
    if any(each.pushers for each in plans):
        signs[WORDS["pushes"]] = _marker(">", INK, 9)
    return signs


def _patch(color: Color, **style: Any) -> Rectangle:
    return Rectangle((0, 0), 1, 1, facecolor=color, **style)


def _marker(marker: str, color: Color, size: float = 10) -> Line2D:
    edge: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}
    return Line2D([], [], marker=marker, markersize=size, markerfacecolor=color, **edge)
