"""A page that plays tracks: a single HTML file that needs only a browser and loads nothing.

The page is assembled from files of this folder. Text from users is only in the data, which is never
interpreted as markup. The Content-Security-Policy of the page allows only its own script and style.
"""

from __future__ import annotations

import html
import json
import re
from base64 import b64encode
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path

from warehouse_core.arguments import instance_of, real_number, whole_number
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import LOOK, PALETTE, style_rules
from warehouse_core.viz.player.tracks import packed
from warehouse_core.viz.tracks.track import MAX_PACE, MIN_PACE, Track
from warehouse_core.wording import printable

FOLDER = files("warehouse_core.viz.player")

SCRIPTS = (
    "scale.js", "track.js", "canvas.js", "elements.js", "floor.js", "bodies.js",
    "paths.js", "charts.js", "legend.js", "panel.js", "fleet.js", "player.js", "main.js",
)  # fmt: skip
"""Files of the script. Each imports only earlier ones, so that they can be joined into one."""

IMPORT = re.compile(r"^import [^;]*;\n", re.MULTILINE)
EXPORT = re.compile(r"^export ", re.MULTILINE)

MAX_TITLE = 200

FRAME_HEIGHT = 640
"""Default height of a page within another page, in pixels."""

MAX_FRAME_HEIGHT = 100_000


def player_page(
    tracks: Sequence[Track],
    *,
    title: str = "",
    speed: float = 1.0,
    opens_at: float | None = None,
) -> str:
    """Return an HTML page that plays tracks side by side, with one clock.

    When the page opens, it plays once and stops at the end. Any key or click stops it earlier. For
    readers who prefer reduced motion (``prefers-reduced-motion``) it stays at the start.

    Args:
        tracks: tracks, at least one, each with at least one frame.
        title: title of the page; by default the titles of the tracks.
        speed: factor on the playing speed.
        opens_at: simulated second (on the grid: step) at which the page opens, without playing; by
            default the page plays from the start.

    Raises:
        ValueError: ``speed`` is not within ``MIN_PACE`` and ``MAX_PACE``, ``opens_at`` is negative
            or not finite, or a position is not finite.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.player import player_page
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> player_page([track_of_record(episode)], title="Seed 12")[:15]
        '<!DOCTYPE html>'
    """
    speed = real_number("speed", speed, MIN_PACE, MAX_PACE)
    if opens_at is not None:
        opens_at = real_number("opens_at", opens_at, 0.0)
    titles = dict.fromkeys(track.title for track in tracks if track.title)
    title = printable(instance_of("title", title, str) or " / ".join(titles) or "Warehouse replay")
    parts = {
        "policy": policy(),
        "title": html.escape(title[:MAX_TITLE]),
        "style": style(),
        "data": packed(tracks, title, speed, opens_at),
        "script": script(),
    }
    page = (FOLDER / "player.html").read_text(encoding="utf-8")
    return re.sub(r"\{([a-z]+)\}", lambda match: parts[match[1]], page)


def save_page(
    path: str | Path, tracks: Sequence[Track], *, title: str = "", speed: float = 1.0
) -> None:
    """Write the page that ``player_page`` returns, either completely or not at all.

    Raises:
        OSError: the file cannot be written.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.player import save_page
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> save_page("replay.html", [track_of_record(episode)])
    """
    page = player_page(tracks, title=title, speed=speed)
    with atomic_path(path) as part:
        part.write_text(page, encoding="utf-8")


def player_frame(
    tracks: Sequence[Track],
    *,
    title: str = "",
    speed: float = 1.0,
    height: int = FRAME_HEIGHT,
) -> str:
    """Return ``player_page`` as a frame for another page, ``height`` pixels high.

    A frame plays by itself only while its first floor is visible. Its script cannot access the
    surrounding page. If that page has a Content-Security-Policy, it must allow
    ``digest(script())``.

    Raises:
        ValueError: as for ``player_page``, or ``height`` is not within 1 and
            ``MAX_FRAME_HEIGHT``.
        TypeError: ``height`` is not an integer.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.viz.player import player_frame
        >>> from warehouse_core.viz.tracks import track_of_record
        >>> episode = record_episode(WarehouseEnv(), GreedyAgent(seed=12), seed=12)
        >>> player_frame([track_of_record(episode)], height=480)[:7]
        '<iframe'
    """
    height = whole_number("height", height, 1, MAX_FRAME_HEIGHT)
    page = html.escape(player_page(tracks, title=title, speed=speed))
    name = html.escape(printable(title or "Replay"))
    return (
        f'<iframe srcdoc="{page}" sandbox="allow-scripts" allow="fullscreen" '
        f'title="{name}" style="width:100%;height:{height}px;border:0"></iframe>'
    )


@cache
def script() -> str:
    """Return the script of the page, including the colours and the look of tiles."""
    return _joined(SCRIPTS)


def floor_module() -> str:
    """Return a JavaScript module that draws floors, for other pages."""
    files = SCRIPTS[: SCRIPTS.index("floor.js") + 1]
    return f"{_joined(files)}export {{ Brush, LOOK, View, drawFloor, drawLetters, readTheme }};\n"


def _joined(files: Sequence[str]) -> str:
    texts = [(FOLDER / name).read_text(encoding="utf-8") for name in files]
    data = f"const PALETTE = {json.dumps(PALETTE)}, LOOK = {json.dumps(LOOK)};\n"
    return data + "".join(EXPORT.sub("", IMPORT.sub("", text)) for text in texts)


@cache
def style() -> str:
    """Return the style sheet, beginning with the palette."""
    return style_rules() + (FOLDER / "player.css").read_text(encoding="utf-8")


def policy() -> str:
    """Return the Content-Security-Policy of the page."""
    return (
        f"default-src 'none'; script-src {digest(script())}; style-src {digest(style())}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )


def digest(text: str) -> str:
    """Return the hash of an inline script or style, in the format of a policy."""
    return f"'sha256-{b64encode(sha256(text.encode('utf-8')).digest()).decode('ascii')}'"
