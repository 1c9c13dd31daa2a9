"""Write a replay to a file whose suffix names the format; the file appears whole or not at all."""

from __future__ import annotations

import html
import re
import sys
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter
from PIL import Image

from warehouse_core.atomic_file import atomic_path
from warehouse_core.scene_figure import SceneFigure

if TYPE_CHECKING:
    from warehouse_core.replay import Replay

LAST_FRAME_MS = 2000
"""How long a GIF rests on its last frame before it starts again."""

GIF_FRAME_MS = (20, 655_350)
"""Shortest and longest time of a frame: viewers play shorter ones slowly, the file has 16 bits."""

LONG_EXPORT = 40
"""Frames from which a progress bar is shown, on a terminal."""


class FormatError(ValueError):
    """A file format that there is not, or one whose requirements are not installed."""


Progress = Callable[[int, int | None], None]


def export(replay: Replay, path: Path) -> None:
    """Write ``replay`` to ``path``.

    Raises:
        FormatError: a suffix that is not in ``FORMATS``, or MP4 without imageio-ffmpeg.
        OSError: the file cannot be written.
    """
    write = FORMATS[check_format(path)]
    try:
        with atomic_path(path) as part:
            write(replay, part)
    finally:
        replay.refresh()


def check_format(path: Path, also: Sequence[str] = ()) -> str:
    """Return the suffix of ``path``, refusing one that is no format here nor one of ``also``.

    Raises:
        FormatError: listing what is allowed.
    """
    suffix = path.suffix.lower()
    if suffix not in (allowed := [*FORMATS, *also]):
        raise FormatError(
            f"{path}: cannot save as {suffix or 'a file without a suffix'}; "
            f"allowed: {', '.join(allowed)}"
        )
    return suffix


@contextmanager
def progress_bar(frames: int, label: str) -> Iterator[Progress]:
    """Yield a callback for ``(frame, frames)`` that moves a bar on standard error.

    Short exports and output that is not a terminal get no bar.
    """
    from rich.console import Console
    from rich.progress import Progress as Bar

    quiet = frames < LONG_EXPORT or not sys.stderr.isatty()
    with Bar(console=Console(stderr=True), transient=True, disable=quiet) as bar:
        task = bar.add_task(label, total=frames)
        yield lambda frame, _: bar.update(task, completed=frame + 1)


def self_contained(page: str) -> str:
    """Give matplotlib's player its button signs by style, in place of a font from elsewhere."""
    return re.sub(r"<link\b[^>]*>", lambda _: _BUTTON_STYLE, page)


def save_svg(figure: SceneFigure, path: Path, dpi: float | None = None) -> None:
    """Write a figure as SVG whose bytes depend on nothing but what it shows."""
    with mpl.rc_context({"svg.hashsalt": "warehouse-lab", "svg.fonttype": "path"}):
        figure.savefig(path, format="svg", dpi=dpi or figure.dpi, metadata={"Date": None})


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


class _GifWriter(AbstractMovieWriter):
    """Keeps the frames compressed, so that a long replay fits into memory."""

    def __init__(self, figure: SceneFigure, frame_ms: float) -> None:
        super().__init__(fps=1000 / frame_ms)  # type: ignore[arg-type] # any number will do
        shortest, longest = GIF_FRAME_MS
        self._figure, self._frame_ms = figure, round(min(max(frame_ms, shortest), longest))
        self._frames: list[bytes] = []

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)

    def grab_frame(self, **_: Any) -> None:
        self._frames.append(zlib.compress(self._figure.indexed_pixels().tobytes(), 1))

    def finish(self) -> None:
        images = self._images()
        durations = [self._frame_ms] * (len(self._frames) - 1) + [LAST_FRAME_MS]
        next(images).save(
            self.outfile,
            format="GIF",
            save_all=True,
            append_images=images,
            duration=durations,
            loop=0,
        )

    def _images(self) -> Iterator[Image.Image]:
        template = self._figure.indexed_pixels()
        for data in self._frames:
            image = template.copy()
            image.frombytes(zlib.decompress(data))
            yield image


def _save_gif(replay: Replay, path: Path) -> None:
    replay.save(path, writer=_GifWriter(replay.figure, replay.frame_ms))


def _save_mp4(replay: Replay, path: Path) -> None:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        raise FormatError(
            "saving as .mp4 needs imageio-ffmpeg: pip install 'warehouse-lab[video]'"
        ) from error
    with mpl.rc_context({"animation.ffmpeg_path": get_ffmpeg_exe()}):
        replay.save(path, writer=FFMpegWriter(replay.fps, codec="h264"))


def _save_html(replay: Replay, path: Path) -> None:
    title = html.escape(replay.track.title or "Warehouse replay")
    path.write_text(_PAGE.format(title=title, player=replay.to_jshtml()), encoding="utf-8")


def _save_svg(replay: Replay, path: Path) -> None:
    replay.show_end()
    save_svg(replay.figure, path)


def _save_png(replay: Replay, path: Path) -> None:
    replay.show_end()
    replay.figure.pixels().save(path, format="PNG")


FORMATS: dict[str, Callable[[Replay, Path], None]] = {
    ".gif": _save_gif,
    ".mp4": _save_mp4,
    ".html": _save_html,
    ".svg": _save_svg,
    ".png": _save_png,
}
