"""The legend of a replay: what is in its picture, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from matplotlib.artist import Artist
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import (
    BOARD,
    COLORS,
    HIT,
    ICE,
    ICE_WAVE,
    INK,
    ITEM,
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
from warehouse_core.viz.axes.plans import WISH_STYLE
from warehouse_core.viz.axes.tiles import cells_of, is_on_border
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks.history import History
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import LOW_BATTERY, ROUTE_STYLE, WEAK_MOTOR, is_open
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import PERSON, PICKUP, ROBOT_EMPTY, ROBOT_LOADED, TILES, WALL

ORDER_WORDS = (", new", ", older", ", nearly due", ", late (!)")

Signs = dict[str, Artist]

EDGE: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}


def draw_legend(figure: SceneFigure, tracks: Sequence[Track], columns: int = 0) -> Legend:
    """Draw the legend of what tracks show, in columns along the bottom or one on the right side.

    Return the legend.
    """
    signs: Signs = {}
    for track in tracks:
        signs |= signs_of(track)
    place: dict[str, Any] = {"loc": "center right", "ncols": 1, "labelspacing": 0.7}
    if columns:
        place = {"loc": "lower center", "ncols": columns}
    return figure.legend(
        [*signs.values()], [*signs], fontsize=SMALLEST, frameon=False, handlelength=2.0,
        columnspacing=1.4, handletextpad=0.5, **place,
    )  # fmt: skip


def signs_of(track: Track) -> Signs:
    """Return the signs in any frame of a track, by what they mean."""
    poses = [pose for frame in track.frames for pose in frame.robots if pose is not None]
    signs = _tile_signs(track)
    for kind, loaded in ((ROBOT_EMPTY, False), (ROBOT_LOADED, True)):
        if any(pose.loaded == loaded for pose in poses):
            words = LEGEND[kind] if track.is_fleet else f"{kind}  {LEGEND[kind]}"
            signs[words] = _marker("o", COLORS[kind])
    if track.is_fleet:
        signs |= _fleet_signs(track)
    else:
        signs |= _lone_signs(track)
    if any(frame.hits for frame in track.frames):
        signs["blocked" if track.is_fleet else "hit"] = _marker("*", HIT, 11)
    if track.motor_strength < 1:
        dashed: dict[str, Any] = {"linestyle": WEAK_MOTOR, "lw": 1.4}
        signs[f"motors at {track.motor_strength:.0%}"] = _patch(PAPER, edgecolor=INK, **dashed)
    return signs


def _tile_signs(track: Track) -> Signs:
    signs: Signs = {}
    all_rows = {frame.tiles for frame in track.frames}
    for tile in TILES:
        on_border = {
            is_on_border(cell, (len(rows), len(rows[0])))
            for rows in all_rows
            for cell in cells_of(tile, rows)
        }
        if tile == WALL and False in on_border:
            signs[f"{tile}  shelf"] = _patch(SHELF, edgecolor=BOARD, hatch="--", lw=0)
        if on_border and (tile != WALL or True in on_border):
            signs[f"{tile}  {TILES[tile]}"] = _marker("s", COLORS[tile])
    if any(is_open(rows, cell) for rows in all_rows for cell in track.slippery):
        signs["slippery floor"] = _patch(ICE, edgecolor=ICE_WAVE, hatch="\\\\\\", lw=0)
    if any(frame.route for frame in track.frames):
        signs["not seen yet"] = _patch(UNKNOWN, edgecolor=UNKNOWN_STRIPE, hatch="///", lw=0)
        signs["plan"] = Line2D([], [], color=INK, linestyle=ROUTE_STYLE, lw=2.2)
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
        signs["item"] = _marker("s", ITEM, 8)
    if track.view_radius is not None and len(histories) == 1:
        signs["what the robot does not see"] = _patch(INK, alpha=SHADOW, lw=0)
    if any(max(history.visits(track.steps).values(), default=0) > 1 for history in histories):
        signs["visited often"] = _patch(VISITED[-1], lw=0)
    moves = {
        before.loaded
        for first, second in pairwise(frames)
        for before, after in zip(first.robots, second.robots, strict=True)
        if before and after and before.at != after.at
    }
    for loaded in sorted(moves):
        signs[f"trail {'loaded' if loaded else 'empty'}"] = Line2D(
            [], [], color=TRAIL_COLORS[loaded], linestyle=TRAIL_STYLES[loaded], lw=2.2
        )
    return signs


def _fleet_signs(track: Track) -> Signs:
    """Return the signs of people, orders, batteries and plans."""
    fleets = [frame.fleet for frame in track.frames if frame.fleet]
    ages = {each.age for fleet in fleets for each in fleet.waiting}
    ages |= {age for fleet in fleets for age in fleet.items if age is not None}
    lowest = min((min(fleet.battery) for fleet in fleets), default=1.0)
    signs: Signs = {}
    if len(track.frames[0].robots) > len(fleets[0].battery):
        signs["person"] = _marker("D", COLORS[PERSON], 8)
    for age, words in enumerate(ORDER_WORDS):
        if age in ages:
            signs[f"order{words}"] = _marker("s", ORDER_COLORS[age], 8)
    if lowest < LOW_BATTERY:
        signs["battery low"] = Line2D([], [], color=WARNING, lw=4.0, solid_capstyle="butt")
    if lowest <= 0:
        signs["battery empty"] = _marker("o", STRANDED, 8)
    return signs | _plan_signs([fleet.plans for fleet in fleets])


def _plan_signs(plans: Sequence[StepPlans]) -> Signs:
    """Return the signs of plans ahead of robots."""
    line: dict[str, Any] = {"color": COLORS[ROBOT_EMPTY], "lw": 3.0, "dash_capstyle": "round"}
    signs: Signs = {}
    if any(each.ways for each in plans):
        signs["plan"] = Line2D([], [], **line)
    if any(each.wishes for each in plans):
        signs["shortest way on"] = Line2D([], [], linestyle=WISH_STYLE, **line)
    if any(each.pushers for each in plans):
        signs["pushes"] = Line2D(
            [], [], linestyle="none", marker=">", markersize=9, color=INK, markeredgecolor=PAPER
        )
    return signs


def _patch(color: Color, **style: Any) -> Rectangle:
    return Rectangle((0, 0), 1, 1, facecolor=color, **style)


def _marker(marker: str, color: Color, size: float = 10) -> Line2D:
    return Line2D([], [], marker=marker, markersize=size, markerfacecolor=color, **EDGE)
