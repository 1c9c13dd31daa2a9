"""Lines of text that Pillow draws into pixels, several times faster than matplotlib."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from PIL import Image, ImageDraw, ImageFont

INSET = 2
"""Pixels before and after a line of text, into which its letters may reach."""


class LineOfText(Text):
    """A line of text that Pillow draws into pixels, several times faster than matplotlib.

    Matplotlib draws several lines, letters outside ASCII, and everything that is not pixels.
    """

    def draw(self, renderer: Any) -> None:
        """Draw the text."""
        if not self._is_quick(renderer):
            super().draw(renderer)
            return
        font, left, top, (width, height) = self._placed(renderer)
        mask = Image.new("L", (width, height))
        ImageDraw.Draw(mask).text((INSET, font.above), self.get_text(), 255, font.pillow)
        canvas = np.asarray(renderer.buffer_rgba())
        area = canvas[max(top, 0) : max(top + height, 0), max(left, 0) : max(left + width, 0), :3]
        share = np.asarray(mask)[max(-top, 0) :, max(-left, 0) :][: len(area), : area.shape[1]]
        color = 255 * np.array(to_rgb(self.get_color()), np.float32)
        area[:] = np.rint(area + (color - area) * (share[..., None] / np.float32(255)))
        self.stale = False

    def get_window_extent(self, renderer: Any = None, dpi: float | None = None) -> Bbox:
        """Return the box around the text, in pixels from the bottom left corner."""
        if dpi is not None or not self._is_quick(renderer):
            return super().get_window_extent(renderer, dpi)
        _, left, top, (width, height) = self._placed(renderer)
        return Bbox.from_bounds(left, renderer.height - top - height, width, height)

    def _is_quick(self, renderer: Any) -> bool:
        words, is_raster = self.get_text(), isinstance(renderer, RendererAgg)
        return is_raster and words.isascii() and words.isprintable() and words != ""

    def _placed(self, renderer: Any) -> tuple[LineFont, int, int, tuple[int, int]]:
        """Return the font, and the left, the top and the size of the text in pixels."""
        font = font_of(self.get_fontweight(), renderer.points_to_pixels(self.get_fontsize()))
        length = font.pillow.getlength(self.get_text())
        x, y = self.get_transform().transform(self.get_position())
        before = {"left": 0.0, "center": 0.5, "right": 1.0}[self.get_horizontalalignment()]
        above = {"center": 0.5, "top": 0.0}[self.get_verticalalignment()]
        left = round(x - before * length) - INSET
        top = round(renderer.height - y - above * font.height)
        return font, left, top, (math.ceil(length) + 2 * INSET, font.height)


class LineFont(NamedTuple):
    """A font of Pillow, and the space above and the height of its lines in pixels."""

    pillow: ImageFont.FreeTypeFont
    above: int
    height: int


@cache
def font_of(weight: str | int, pixels: float) -> LineFont:
    """Return the font of matplotlib with a weight and a size."""
    path = findfont(FontProperties(weight=weight))
    font = ImageFont.truetype(path, pixels, layout_engine=ImageFont.Layout.BASIC)
    _, above, _, below = font.getbbox("lp")
    return LineFont(font, -math.floor(above), math.ceil(below - above))
