"""GIF files whose frames share one palette and store only the pixels that change."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import IO

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from warehouse_core.render.palette import indexed_palette
from warehouse_core.viz.pixel_box import PixelBox, around, boxes_of

LAST_FRAME_MS = 2000
"""Milliseconds for which a GIF shows its last frame before it starts again."""

MIN_FRAME_MS, MAX_FRAME_MS = 20, 655_350
"""Limits on the duration of a frame. Viewers slow down shorter frames, and the file has 16 bits for
the duration in hundredths of a second."""

MAX_COLOR = 0xFFFFFF
"""Largest colour, as a number with one byte each for red, green and blue."""

ColorValues = NDArray[np.uint8]


class GifWriter:
    """A writer that stores each frame when the next one arrives, so it needs little memory."""

    def __init__(self, file: IO[bytes], frame_ms: float) -> None:
        self._file = file
        self._frame_ms = round(min(max(frame_ms, MIN_FRAME_MS), MAX_FRAME_MS))
        # The index after the last colour stands for an unchanged pixel.
        self._unchanged = len(indexed_palette()) // 3
        self._known = np.full(MAX_COLOR + 1, self._unchanged, np.uint8)
        self._last: NDArray[np.uint32] | None = None
        self._pending: tuple[Image.Image, tuple[int, int]] | None = None

    def add(self, frame: ColorValues, changed: Sequence[PixelBox]) -> None:
        """Add a frame, ``[height, width, 4]``.

        It may differ from the previous frame only within the boxes ``changed``.
        """
        colors = frame.view("<u4")[..., 0]
        if self._last is None:
            self._last, top, left = colors.copy(), 0, 0
            image = indexed(Image.fromarray(frame).convert("RGB"))
            image.putpalette([*indexed_palette(), 0, 0, 0])
            header, _ = GifImagePlugin.getheader(image, info={"loop": 0})
            self._file.write(b"".join(header))
        else:
            indices = np.full(colors.shape, self._unchanged, np.uint8)
            extents = []
            for box in changed:
                new, differs = colors[box.area], colors[box.area] != self._last[box.area]
                indices[box.area][differs] = self._indices_of(new[differs])
                self._last[box.area] = new
                extents += [each.moved(box.top, box.left) for each in boxes_of(differs)]
            extent = around(extents or [PixelBox(0, 1, 0, 1)])
            image, top, left = Image.fromarray(indices[extent.area]), extent.top, extent.left
        self._write(self._frame_ms)
        self._pending = image, (left, top)

    def finish(self) -> None:
        """Write the last frame and the end of the file."""
        self._write(LAST_FRAME_MS)
        self._file.write(b";")

    def _indices_of(self, colors: NDArray[np.uint32]) -> ColorValues:
        """Return the indices of colours in the palette. Each colour is looked up only once."""
        rgb = colors & MAX_COLOR
        found: ColorValues = self._known.take(rgb)
        missing = found == self._unchanged
        if missing.any():
            new = np.array(sorted({*rgb[missing].tolist()}), "<u4")
            parts = new.view(np.uint8).reshape(1, -1, 4)[..., :3]
            self._known[new] = np.asarray(indexed(Image.fromarray(np.ascontiguousarray(parts))))[0]
            found = self._known.take(rgb)
        return found

    def _write(self, duration: int) -> None:
        if self._pending is None:
            return
        image, offset = self._pending
        options = {"transparency": self._unchanged, "disposal": 1}  # draw over the frame before
        self._file.writelines(GifImagePlugin.getdata(image, offset, duration=duration, **options))


def indexed(image: Image.Image) -> Image.Image:
    """Return an RGB image converted to the colours of ``indexed_palette``."""
    return image.quantize(palette=_palette_image(), dither=Image.Dither.NONE)


@cache
def _palette_image() -> Image.Image:
    palette = Image.new("P", (1, 1))
    palette.putpalette(indexed_palette())
    return palette
