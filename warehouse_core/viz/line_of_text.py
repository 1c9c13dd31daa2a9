"""Lines of text that Pillow draws into pixels, several times faster than matplotlib."""

from __future__ import annotations

import math
from functools import cache, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

INSET = 2
"""Pixels before and after a line of text, into which its letters may reach."""

LINES = 64
"""Number of lines that a font keeps, because most of them are shown again soon."""

Mask = NDArray[np.uint16]


class LineOfText(Text):
    """A line of text that Pillow draws into pixels, several times faster than matplotlib.

    Matplotlib draws several lines, letters outside ASCII, and everything that is not pixels.
    """

    def draw(self, renderer: Any) -> None:
        """Draw the text."""
        if not self._is_quick(renderer):
            super().draw(renderer)
            return
        mask, left, top = self._placed(renderer)
        height, width = mask.shape
        canvas = np.asarray(renderer.buffer_rgba())
        area = canvas[max(top, 0) : max(top + height, 0), max(left, 0) : max(left + width, 0), :3]
        share = mask[max(-top, 0) :, max(-left, 0) :][: len(area), : area.shape[1]]
        color = 255 * np.array(to_rgb(self.get_color()), np.float32)
        area[:] = np.rint(area + (color - area) * (share[..., None] / np.float32(255)))
        self.stale = False

    def get_window_extent(self, renderer: Any = None, dpi: float | None = None) -> Bbox:
        """Return the box around the text, in pixels from the bottom left corner."""
        if dpi is not None or not self._is_quick(renderer):
            return super().get_window_extent(renderer, dpi)
        mask, left, top = self._placed(renderer)
        height, width = mask.shape
        return Bbox.from_bounds(left, renderer.height - top - height, width, height)

    def _is_quick(self, renderer: Any) -> bool:
        words, is_raster = self.get_text(), isinstance(renderer, RendererAgg)
        return is_raster and words.isascii() and words.isprintable() and words != ""

    def _placed(self, renderer: Any) -> tuple[Mask, int, int]:
        """Return the opacity of the letters, and the left and the top of the text in pixels."""
        font = font_of(self.get_fontweight(), renderer.points_to_pixels(self.get_fontsize()))
        mask, length = font.line(self.get_text())
        x, y = self.get_transform().transform(self.get_position())
        before = {"left": 0.0, "center": 0.5, "right": 1.0}[self.get_horizontalalignment()]
        above = {"center": 0.5, "top": 0.0}[self.get_verticalalignment()]
        left = round(x - before * length) - INSET
        return mask, left, round(renderer.height - y - above * len(mask))


class LineFont:
    """A font of Pillow with a size in pixels, which draws each letter only once."""

    def __init__(self, path: str, pixels: float) -> None:
        self._pillow = ImageFont.truetype(path, pixels, layout_engine=ImageFont.Layout.BASIC)
        _, above, _, below = self._pillow.getbbox("lp")
        self._above, self._height = -math.floor(above), math.ceil(below - above)
        # Caches that belong to the font, so that they end with it.
        self._letter, self._length = cache(self._draw), cache(self._pillow.getlength)
        self.line = lru_cache(LINES)(self._compose)

    def _draw(self, letters: str) -> Mask:
        """Return the opacity of letters, drawn by Pillow, ``[height, width]``."""
        size = math.ceil(self._pillow.getlength(letters)) + 2 * INSET, self._height
        mask = Image.new("L", size)
        ImageDraw.Draw(mask).text((INSET, self._above), letters, 255, self._pillow)
        return np.asarray(mask).astype(np.uint16)

    def _compose(self, text: str) -> tuple[Mask, float]:
        """Return the opacity of a line of text, and its length in pixels.

        Pillow also draws letters one over the other, so the result is the same.
        """
        places: list[int] = []
        length = 0.0
        for before, letter in pairwise(["", *text]):
            # Letters move towards each other in pairs such as "AV".
            length += self._length(before + letter) - self._length(before) - self._length(letter)
            places.append(round(length))
            length += self._length(letter)
        mask = np.zeros((self._height, math.ceil(length) + 2 * INSET), np.uint16)
        for letter, left in zip(text, places, strict=True):
            drawn = self._letter(letter)
            under = mask[:, left : left + drawn.shape[1]]
            share = drawn[:, : under.shape[1]] * (255 - under) + 128
            under += (share + (share >> 8)) >> 8
        return mask, length


@cache
def font_of(weight: str | int, pixels: float) -> LineFont:
    """Return the font of matplotlib with a weight and a size."""
    return LineFont(findfont(FontProperties(weight=weight)), pixels)
