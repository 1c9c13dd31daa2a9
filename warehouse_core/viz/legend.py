"""The legend of a replay, which explains only what occurs in its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import (
    BOARD,
    BRAKE,
    COLORS,
    FORCE,
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
    SKID,
    STRANDED,
    TRAIL_COLORS,
    UNKNOWN,
    UNKNOWN_STRIPE,
    VELOCITY,
    VISITED,
    WARNING,
    Color,
    rgb,
)
from warehouse_core.viz.axes.look import SMALLEST
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks import signs
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import DASHES, GHOST, WEAK_MOTOR
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import EMPTY, PERSON, ROBOT_EMPTY, ROBOT_LOADED, WALL

WORDS = LOOK["words"]

DOTTED: dict[str, Any] = {"linestyle": (0, (0.1, 1.6)), "dash_capstyle": "round"}

BODY, ARROW = (tuple((x, -y) for x, y in LOOK["shapes"][key]) for key in ("chassis", "push"))
"""Markers of robots that are bodies, and of arrows."""

MARKERS: dict[str, tuple[Any, Color, float]] = {
    "chassis": (BODY, COLORS[ROBOT_EMPTY], 12),
    "chassis-loaded": (BODY, COLORS[ROBOT_LOADED], 12),
    "velocity": (ARROW, VELOCITY, 9),
    "force": (ARROW, FORCE, 10),
    "brake": ("s", BRAKE, 6),
    ROBOT_EMPTY: ("o", COLORS[ROBOT_EMPTY], 10),
    ROBOT_LOADED: ("o", COLORS[ROBOT_LOADED], 10),
    PERSON: ("D", COLORS[PERSON], 8),
    "wall": ("s", COLORS[WALL], 10),
    "item": ("s", ITEM, 8),
    "hit": ("*", HIT, 11),
    "stranded": ("o", STRANDED, 8),
    "pushes": (">", INK, 9),
    "ends": ("o", PAPER, 10),
    **{f"{signs.ORDER}{age}": ("s", color, 8) for age, color in enumerate(ORDER_COLORS)},
}
"""Shape, colour and size of signs, by name. Stations are not listed: they are coloured squares."""

PATCHES: dict[str, dict[str, Any]] = {
    "shelf": {"facecolor": SHELF, "edgecolor": BOARD, "hatch": "--"},
    "unseen": {"facecolor": UNKNOWN, "edgecolor": UNKNOWN_STRIPE, "hatch": "///"},
    "ice": {"facecolor": ICE, "edgecolor": ICE_WAVE, "hatch": "\\\\\\"},
    "shadow": {"facecolor": INK, "alpha": SHADOW},
    "visited": {"facecolor": VISITED[-1]},
}

ROBOT_LINE: dict[str, Any] = {"color": COLORS[ROBOT_EMPTY], "lw": 3.0}

LINES: dict[str, dict[str, Any]] = {
    "trail": {"color": TRAIL_COLORS[False], "lw": 2.2},
    "trail-loaded": {"color": TRAIL_COLORS[True], "linestyle": (0, DASHES), "lw": 2.2},
    "plan": {"color": INK, "lw": 2.6, **DOTTED},
    "plans": ROBOT_LINE,
    "skid": {"color": SKID, "lw": 3.0},
    "ghost": {"color": INK, "lw": 1.6, "linestyle": (0, GHOST)},
    "ray": {"color": INK, "lw": 1.0, **DOTTED},
    "outline": {"color": INK, "lw": 1.4},
    "path": {"color": WARNING, "lw": 3.0},
    "wishes": ROBOT_LINE | DOTTED,
    "low": {"color": WARNING, "lw": 4.0, "solid_capstyle": "butt"},
}

Signs = dict[str, Artist]


def draw_legend(
    figure: SceneFigure,
    tracks: Sequence[Track],
    columns: int = 0,
    *,
    with_characters: bool = False,
) -> Legend:
    """Draw and return the legend of some tracks.

    Args:
        figure: figure to draw into.
        tracks: tracks whose signs the legend explains.
        columns: columns of a legend along the bottom; 0 puts it on the right side, in one column.
        with_characters: also explain the characters of tiles, as ``render_with_legend`` does.
    """
    found: Signs = {}
    for track in tracks:
        found |= signs_of(track)
    if with_characters:
        found = {f"{WALL} {WORDS['wall']}" if words == WORDS["wall"] else words: sign
                 for words, sign in found.items()}  # fmt: skip
        found[f"{EMPTY} {LEGEND[EMPTY]}"] = _marker("s", COLORS[EMPTY], 10)
    place: dict[str, Any] = {"loc": "center right", "ncols": 1, "labelspacing": 0.7}
    if columns:
        place = {"loc": "lower center", "ncols": columns}
    return figure.legend(
        [*found.values()], [*found], fontsize=SMALLEST, frameon=False, handlelength=2.0,
        columnspacing=1.4, handletextpad=0.5, **place,
    )  # fmt: skip


def signs_of(track: Track) -> Signs:
    """Return the artist of each sign of a track, by its label, with one for weak motors."""
    found = {words: _artist_of(name) for name, words in signs.signs_of(track)}
    if track.motor_strength < 1:
        words = f"motors at {track.motor_strength:.0%}"
        found[words] = Rectangle(
            (0, 0), 1, 1, facecolor=PAPER, edgecolor=INK, linestyle=(0, WEAK_MOTOR), lw=1.4
        )
    return found


def _artist_of(name: str) -> Artist:
    if name in LINES:
        return Line2D([], [], **LINES[name])
    if name in MARKERS:
        return _marker(*MARKERS[name])
    if name in COLORS:
        return _marker("s", COLORS[name], 10)
    return Rectangle((0, 0), 1, 1, lw=0, **PATCHES.get(name) or {"facecolor": rgb(name)})


def _marker(marker: Any, color: Color, size: float) -> Line2D:
    edge: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}
    return Line2D([], [], marker=marker, markersize=size, markerfacecolor=color, **edge)
