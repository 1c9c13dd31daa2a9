"""A box of pixels in a figure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from matplotlib.transforms import Bbox
from numpy.typing import NDArray


class PixelBox(NamedTuple):
    """The rows from ``top`` to before ``bottom``, and the columns from ``left`` to ``right``."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def area(self) -> tuple[slice, slice]:
        """The index of these pixels in an array ``[height, width, ...]``."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def moved(self, down: int, right: int) -> PixelBox:
        """Return the box moved by a number of pixels."""
        return PixelBox(self.top + down, self.bottom + down, self.left + right, self.right + right)

    def common(self, other: PixelBox) -> PixelBox:
        """Return the part that both boxes have in common; it is empty if they are apart."""
        top, left = max(self.top, other.top), max(self.left, other.left)
        bottom, right = min(self.bottom, other.bottom), min(self.right, other.right)
        return PixelBox(top, max(top, bottom), left, max(left, right))

    def bounds(self, height: int) -> Bbox:
        """Return the bounds of the box in a figure of a height, whose rows count from below."""
        return Bbox([(self.left, height - self.bottom), (self.right, height - self.top)])


def box_around(extent: Bbox, margin: float, height: int) -> PixelBox:
    """Return the box of an extent with a margin, in pixels, in a figure of a height."""
    left, right = (round(x) for x in (extent.x0 - margin, extent.x1 + margin))
    top, bottom = (round(height - y) for y in (extent.y1 + margin, extent.y0 - margin))
    return PixelBox(max(top, 0), max(bottom, 0), max(left, 0), max(right, 0))


def around(boxes: Iterable[PixelBox]) -> PixelBox:
    """Return the smallest box that contains all of the boxes."""
    tops, bottoms, lefts, rights = zip(*boxes, strict=True)
    return PixelBox(min(tops), max(bottoms), min(lefts), max(rights))


def boxes_of(flags: NDArray[np.bool_]) -> list[PixelBox]:
    """Return the smallest box that contains all true flags ``[height, width]``, or no box."""
    rows, columns = (np.flatnonzero(flags.any(axis=axis)).tolist() for axis in (1, 0))
    return [PixelBox(rows[0], rows[-1] + 1, columns[0], columns[-1] + 1)] if rows else []
