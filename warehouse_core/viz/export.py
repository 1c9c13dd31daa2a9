"""Write a replay to a file in the format of its suffix; the file appears whole or not at all."""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import matplotlib as mpl
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter

from warehouse_core.errors import FormatError
from warehouse_core.files.atomic import atomic_path, check_suffix
from warehouse_core.viz.figure import SceneFigure, save_svg
from warehouse_core.viz.gif_writer import GifWriter

MIN_BAR_FRAMES = 40
"""Exports with fewer frames show no progress bar."""

Progress = Callable[[int, int | None], None]


class Film(Protocol):
    """What can be exported; a ``Replay`` is one."""

    title: str
    frame_ms: float
    fps: Any
    figure: SceneFigure

    def save(self, filename: str | Path, writer: AbstractMovieWriter) -> None:
        """Write every frame with a writer of matplotlib."""

    def to_jshtml(self) -> str:
        """Return a player with every frame as HTML."""

    def show_end(self) -> None:
        """Draw the last frame."""

    def refresh(self) -> None:
        """Draw the current frame again."""


def export(film: Film, path: Path) -> None:
    """Write ``film`` to ``path``.

    Raises:
        FormatError: a suffix that is not in ``FORMATS``, or MP4 without imageio-ffmpeg.
        OSError: the file cannot be written.
    """
    write = FORMATS[check_format(path)]
    try:
        with atomic_path(path) as part:
            write(film, part)
    finally:
        film.refresh()


def check_format(path: Path, also: Sequence[str] = ()) -> str:
    """Return the suffix of ``path`` in lower case; ``also`` are allowed beside ``FORMATS``.

    Raises:
        FormatError: another suffix; the message lists those allowed.
    """
    return check_suffix(path, [*FORMATS, *also])


@contextmanager
def progress_bar(frames: int, label: str) -> Iterator[Progress]:
    """Yield a callback for ``(frame, frames)`` that moves a bar on standard error.

    There is no bar for short exports, or where standard error is no terminal.
    """
    from rich.console import Console
    from rich.progress import Progress as Bar

    quiet = frames < MIN_BAR_FRAMES or not sys.stderr.isatty()
    with Bar(console=Console(stderr=True), transient=True, disable=quiet) as bar:
        task = bar.add_task(label, total=frames)
        yield lambda frame, _: bar.update(task, completed=frame + 1)


def self_contained(page: str) -> str:
    """Return a player whose button signs come from a style, not from a font on the network."""
    return re.sub(r"<link\b[^>]*>", lambda _: _BUTTON_STYLE, page)


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


def _save_gif(film: Film, path: Path) -> None:
    with film.figure.drawn_on_demand():
        film.save(path, GifWriter(film.figure, film.frame_ms))


def _save_mp4(film: Film, path: Path) -> None:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        raise FormatError(
            "saving as .mp4 needs imageio-ffmpeg: pip install 'warehouse-lab[video]'"
        ) from error
    with mpl.rc_context({"animation.ffmpeg_path": get_ffmpeg_exe()}):
        film.save(path, FFMpegWriter(film.fps, codec="h264"))


def _save_html(film: Film, path: Path) -> None:
    title = html.escape(film.title or "Warehouse replay")
    path.write_text(_PAGE.format(title=title, player=film.to_jshtml()), encoding="utf-8")


def _save_svg(film: Film, path: Path) -> None:
    film.show_end()
    save_svg(film.figure, path)


def _save_png(film: Film, path: Path) -> None:
    film.show_end()
    film.figure.pixels().save(path, format="PNG")


FORMATS: dict[str, Callable[[Film, Path], None]] = {
    ".gif": _save_gif,
    ".mp4": _save_mp4,
    ".html": _save_html,
    ".svg": _save_svg,
    ".png": _save_png,
}
