"""A matplotlib writer of GIF files that share one palette and store only what changes."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter
from numpy.typing import NDArray
from PIL import Image

from warehouse_core.render.palette import indexed_palette
from warehouse_core.viz.figure import SceneFigure

LAST_FRAME_MS = 2000
"""How long a GIF shows its last frame before it starts again."""

MIN_FRAME_MS, MAX_FRAME_MS = 20, 655_350
"""Viewers play shorter frames slowly; the file has 16 bits for hundredths of a second."""

KEEP_FRAME = 1
"""The disposal method of a GIF that draws each frame over the one before."""

Pixels = NDArray[np.uint8]
"""``[height, width]`` of indices into the palette."""


class GifWriter(AbstractMovieWriter):
    """Keeps the changes of each frame, compressed, so that a long replay fits into memory."""

    def __init__(self, figure: SceneFigure, frame_ms: float) -> None:
        super().__init__(fps=1000 / frame_ms)  # type: ignore[arg-type] # it may be a fraction
        self._figure = figure
        self._frame_ms = round(min(max(frame_ms, MIN_FRAME_MS), MAX_FRAME_MS))
        palette = indexed_palette()
        # The index after the last colour means unchanged. Pillow would find the unchanged pixels
        # too, but one by one.
        self._unchanged = len(palette) // 3
        self._palette = [*palette, 0, 0, 0]
        self._last: Pixels | None = None
        self._frames: list[bytes] = []

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin a file."""
        super().setup(fig, outfile, dpi)

    def grab_frame(self, **_: Any) -> None:
        """Add the figure as it is now."""
        pixels = np.asarray(self._figure.indexed_pixels())
        same = False if self._last is None else pixels == self._last
        changed = np.where(same, np.uint8(self._unchanged), pixels)
        self._frames.append(zlib.compress(changed.tobytes(), 1))
        self._last = pixels

    def finish(self) -> None:
        """Write the file; nothing, if an exception came before the first frame."""
        if self._last is None:
            return
        images = self._images(*self._last.shape)
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
            disposal=KEEP_FRAME,
        )

    def _images(self, height: int, width: int) -> Iterator[Image.Image]:
        for data in self._frames:
            image = Image.frombytes("P", (width, height), zlib.decompress(data))
            image.putpalette(self._palette)
            yield image
