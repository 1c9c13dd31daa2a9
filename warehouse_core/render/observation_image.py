"""Pictures of observations.

A picture shows the cells in view. Outside the view, only the first pickup and the first dropoff are
known, and all other cells are hatched. Two bars below show the battery level and the steps taken.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.render.atlas import CODES, NO_ROBOT, ROBOT_CODES, UNSEEN, Pixels, atlas
from warehouse_core.render.painter import TilePainter, bar
from warehouse_core.render.palette import BATTERY, INK
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.world.tiles import DROPOFF, EMPTY, PICKUP

TILE_PIXELS = 8
"""Side of a tile in pixels; the picture of the default layout has 64 x 96 pixels."""

_gauge = lru_cache(maxsize=4096)(bar)
"""Bars take half of the time of a picture, and most observations share theirs."""

STATION_CODES = (CODES[PICKUP, NO_ROBOT], CODES[DROPOFF, NO_ROBOT])


class ObservationImage:
    """A painter of single observations or batches of them.

    Args:
        height: number of rows of the layout, ``H``.
        width: number of columns of the layout, ``W``.
        battery: units of a full battery.
        max_steps: number of steps after which an episode is truncated.

    Example:
        >>> from warehouse_core import WarehouseEnv
        >>> from warehouse_core.render import ObservationImage
        >>> from warehouse_core.task import encode
        >>> ObservationImage(7, 12, 200, 200).paint(encode(WarehouseEnv().reset())).shape
        (64, 96, 3)
    """

    def __init__(self, height: int, width: int, battery: int, max_steps: int) -> None:
        self._height, self._width = (
            whole_number("height", height, 1),
            whole_number("width", width, 1),
        )
        self._battery = whole_number("battery", battery, 1)
        self._max_steps = whole_number("max_steps", max_steps, 1)
        self._atlas = atlas(TILE_PIXELS)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Height, width and channels of a picture. The bars are as high as one tile."""
        return (self._height + 1) * TILE_PIXELS, self._width * TILE_PIXELS, 3

    @cached_property
    def _unseen(self) -> Pixels:
        """Picture of a layout with no cell in view, with an additional row for the bars."""
        nothing = np.full((self._height + 1, self._width), CODES[UNSEEN, NO_ROBOT])
        return TilePainter(TILE_PIXELS).paint(nothing)

    def paint(self, arrays: ObservationArrays) -> Pixels:
        """Return pictures of observations, ``[..., (H + 1) * TILE_PIXELS, W * TILE_PIXELS, 3]``."""
        pictures = np.empty((*arrays["robot_pos"].shape[:-1], *self.shape), np.uint8)
        each = pictures.reshape(-1, *self.shape)
        each[:] = self._unseen
        windows = arrays["local_grid"].reshape(len(each), -1)
        numbers = np.column_stack(
            [
                arrays["robot_pos"].reshape(-1, 2),
                arrays["pickup_pos"].reshape(-1, 2),
                arrays["dropoff_pos"].reshape(-1, 2),
                arrays["battery"].reshape(-1),
                arrays["steps"].reshape(-1),
            ]
        ).tolist()
        loaded = np.reshape(arrays["has_item"], -1).tolist()
        for picture, window, known, has_item in zip(each, windows, numbers, loaded, strict=True):
            self._paint(picture, window, known, has_item)
        return pictures

    def _paint(
        self, picture: Pixels, window: NDArray[Any], known: list[int], has_item: int
    ) -> None:
        """Paint an observation over the picture ``_unseen``; ``known`` has its eight numbers."""
        row, col, *stations, battery, steps = known
        end, half = self._height * TILE_PIXELS, TILE_PIXELS // 2
        cells = picture[:end].reshape(self._height, TILE_PIXELS, self._width, TILE_PIXELS, 3)
        under = CODES[EMPTY, NO_ROBOT]
        for code, place in zip(STATION_CODES, (stations[:2], stations[2:]), strict=True):
            if place[0] >= 0:
                cells[place[0], :, place[1]] = self._atlas[code]
            if place == [row, col]:
                under = code
        side = math.isqrt(len(window))
        top, left = row - side // 2, col - side // 2
        tiles = self._atlas.take(window, axis=0).reshape(side, side, *self._atlas.shape[1:])
        shown = tiles[max(-top, 0) : self._height - top, max(-left, 0) : self._width - left]
        rows, cols = slice(max(top, 0), top + side), slice(max(left, 0), left + side)
        cells[rows, :, cols] = shown.swapaxes(1, 2)
        cells[row, :, col] = self._atlas[ROBOT_CODES[has_item, under]]
        width = picture.shape[1]
        picture[end : end + half] = _gauge(battery / self._battery, width, half, BATTERY)
        picture[end + half :] = _gauge(steps / self._max_steps, width, half, INK)
