"""Write a replay to a file whose suffix names the format; the file appears whole or not at all."""

from __future__ import annotations

import html
import re
import sys
import zlib
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from warehouse_core.arguments import real_number
from warehouse_core.errors import FormatError
from warehouse_core.files.atomic import atomic_path
from warehouse_core.render.palette import indexed_palette
from warehouse_core.viz.figure import SceneFigure

if TYPE_CHECKING:
    from warehouse_core.viz.replay import Replay

from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene, draw_legend
from warehouse_core.viz.track import Track

LAST_FRAME_MS = 2000
"""How long a GIF rests on its last frame before it starts again."""

GIF_FRAME_MS = (20, 655_350)
"""Shortest and longest time of a frame: viewers play shorter ones slowly, the file has 16 bits."""

KEEP_WHAT_IS_THERE = 1
"""What a GIF says is to be done with a frame before the next is drawn over it."""

LONG_EXPORT = 40
"""Frames from which a progress bar is shown, on a terminal."""


Pixels = NDArray[np.uint8]
"""``[height, width]`` of indices into the palette."""

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
    return check_suffix(path, [*FORMATS, *also])


def check_suffix(path: Path, allowed: Collection[str]) -> str:
    """Return the suffix of ``path`` in lower case, refusing one that is not allowed.

    Raises:
        FormatError: listing what is allowed.
    """
    suffix = path.suffix.lower()
    if suffix not in allowed:
        given = suffix or "a file without a suffix"
        raise FormatError(f"{path}: cannot save as {given}; allowed: {', '.join(allowed)}")
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


def save_svg(figure: Figure, target: Path | IO[bytes], dpi: float | None = None) -> None:
    """Write a figure as SVG whose bytes depend on nothing but what it shows."""
    with mpl.rc_context({"svg.hashsalt": "warehouse-lab", "svg.fonttype": "path"}):
        figure.savefig(target, format="svg", dpi=dpi or figure.dpi, metadata={"Date": None})


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
    """Keeps of each frame what has changed, compressed, so that a long replay fits into memory."""

    def __init__(self, figure: SceneFigure, frame_ms: float) -> None:
        super().__init__(fps=1000 / frame_ms)  # type: ignore[arg-type] # any number will do
        shortest, longest = GIF_FRAME_MS
        self._figure, self._frame_ms = figure, round(min(max(frame_ms, shortest), longest))
        palette = indexed_palette()
        # The index after the last colour stands for what stays as it was; Pillow finds it as well,
        # but pixel by pixel.
        self._unchanged = len(palette) // 3
        self._palette = [*palette, 0, 0, 0]
        self._last: Pixels | None = None
        self._frames: list[bytes] = []

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)

    def grab_frame(self, **_: Any) -> None:
        pixels = np.asarray(self._figure.indexed_pixels())
        same = False if self._last is None else pixels == self._last
        changed = np.where(same, np.uint8(self._unchanged), pixels)
        self._frames.append(zlib.compress(changed.tobytes(), 1))
        self._last = pixels

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
            optimize=False,  # done here already
            transparency=self._unchanged,
            disposal=KEEP_WHAT_IS_THERE,
        )

    def _images(self) -> Iterator[Image.Image]:
        assert self._last is not None, "every replay has a frame"
        height, width = self._last.shape
        for data in self._frames:
            image = Image.frombytes("P", (width, height), zlib.decompress(data))
            image.putpalette(self._palette)
            yield image


def _save_gif(replay: Replay, path: Path) -> None:
    with replay.figure.drawn_on_demand():
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
    title = html.escape(replay.title or "Warehouse replay")
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

LEGEND_INCHES = (6.0, 0.6)


def save_frames(track: Track, folder: Path, dpi: float) -> None:
    """Write ``frame_0000.svg`` and so on and ``legend.svg`` into ``folder``.

    Raises:
        ValueError: ``dpi`` is not a positive finite number.
        OSError: the folder cannot be made or written to.
    """
    real_number("dpi", dpi, above=True)
    folder.mkdir(parents=True, exist_ok=True)
    track.metrics, track.clock = {}, []
    scene = Scene(track, make_figure, legend=False)
    with progress_bar(len(track), "Drawing") as report:
        for frame in range(len(track)):
            scene.show(frame)
            with atomic_path(folder / f"frame_{frame:04d}.svg") as part:
                save_svg(scene.root, part, dpi)
            report(frame, None)
    legend = make_figure(LEGEND_INCHES)
    draw_legend(legend)
    with atomic_path(folder / "legend.svg") as part:
        save_svg(legend, part, dpi)
