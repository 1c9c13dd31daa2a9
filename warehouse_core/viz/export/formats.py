"""The formats of replays, and what writing them needs: a progress bar, pages and ffmpeg."""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from warehouse_core.errors import FormatError
from warehouse_core.extras import install_command

FORMATS = (".gif", ".mp4", ".html", ".svg", ".png")

MIN_BAR_FRAMES = 40
"""Exports with fewer frames show no progress bar."""

Progress = Callable[[int, int | None], None]


@contextmanager
def progress_bar(frames: int, label: str) -> Iterator[Progress]:
    """Yield a callback for ``(frame, frames)`` that moves a bar on standard error.

    There is no bar for short exports, or where standard error is no terminal.
    """
    if frames < MIN_BAR_FRAMES or not sys.stderr.isatty():
        yield lambda frame, _: None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    with Bar(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=frames)
        yield lambda frame, _: bar.update(task, completed=frame + 1)


_SIGNS = {
    "minus": "\u2212",
    "fast-backward": "\u00ab",
    "step-backward": "\u2039",
    "play": "\u25b6",
    "pause": "\u2016",
    "step-forward": "\u203a",
    "fast-forward": "\u00bb",
    "plus": "+",
}

_BUTTON_STYLE = (
    "<style>.fa{font:bold 16px/24px sans-serif}"
    ".fa-flip-horizontal{display:inline-block;transform:scaleX(-1)}"
    + "".join(f'.fa-{name}::before{{content:"{sign}"}}' for name, sign in _SIGNS.items())
    + "</style>"
)

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{title}</title>
<style>body{{margin:1rem;text-align:center}}.animation img{{max-width:100%}}</style></head>
<body>
{player}
</body>
</html>
"""


def self_contained(player: str) -> str:
    """Return a player whose button signs come from a style, not from a font on the network."""
    return re.sub(r"<link\b[^>]*>", lambda _: _BUTTON_STYLE, player)


def page(title: str, player: str) -> str:
    """Return a page with a player."""
    return _PAGE.format(title=html.escape(title or "Warehouse replay"), player=player)


def ffmpeg() -> str:
    """Return the path of the program that writes MP4.

    Raises:
        FormatError: imageio-ffmpeg is not installed.
    """
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        raise FormatError(
            f"saving as .mp4 needs imageio-ffmpeg: {install_command('video')}"
        ) from error
    return str(get_ffmpeg_exe())
