"""The legend of a replay, which explains only what occurs in its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from warehouse_core.render.palette import COLORS, INK, LOOK, PALETTE, PAPER, hex_color
from warehouse_core.viz.axes import SMALLEST
from warehouse_core.viz.figure import SceneFigure
from warehouse_core.viz.tracks import signs
from warehouse_core.viz.tracks.track import Track
from warehouse_core.viz.view import DASHES, GHOST, WEAK_MOTOR
from warehouse_core.warehouse_env import LEGEND
from warehouse_core.world.tiles import EMPTY, WALL

WORDS = LOOK["words"]

HATCHES = {
    "shelf": ("--", "board"),
    "unseen": ("///", "stripe"),
    "ice": ("\\\\\\", "wave"),
}
"""Patterns of tiles, with the names of their colours."""

LINES: dict[str, dict[str, Any]] = {
    "line": {"linewidth": 3.0},
    "line dashed": {"linewidth": 3.0, "linestyle": (0, DASHES)},
    "dots": {"linewidth": 3.0, "linestyle": (0, (0.1, 1.6)), "dash_capstyle": "round"},
    "ghost": {"linewidth": 1.6, "linestyle": (0, GHOST)},
}
"""Styles of the lines among the looks of signs."""

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
        found[f"{EMPTY} {LEGEND[EMPTY]}"] = _marker("s", hex_color(COLORS[EMPTY]))
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
    style, color, shape = signs.look_of(name)
    colors = PALETTE["light"] | PALETTE["both"]
    color = colors.get(color, color)
    if style in LINES:
        return Line2D([], [], color=color, **LINES[style])
    if name in HATCHES:
        hatch, lines = HATCHES[name]
        edge = colors[lines]
        return Rectangle((0, 0), 1, 1, lw=0, facecolor=color, edgecolor=edge, hatch=hatch)
    outline = tuple((x, -y) for x, y in LOOK["shapes"][shape]) if shape and not style else ()
    return _marker(outline or ("o" if "disc" in style else "s"), color)


def _marker(marker: Any, color: str) -> Line2D:
    edge: dict[str, Any] = {"linestyle": "none", "markeredgecolor": INK, "markeredgewidth": 0.6}
    return Line2D([], [], marker=marker, markersize=10, markerfacecolor=color, **edge)
