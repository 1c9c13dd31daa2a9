"""An observation as a picture of its content.

Cells in view are drawn; of the others only the first pickup and dropoff are known, and the rest is
hatched. Two bars below show the battery level and the steps taken.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.render.atlas import CODES, NO_ROBOT, ROBOT_CODES, UNSEEN, Pixels
from warehouse_core.render.painter import TilePainter, bar
from warehouse_core.render.palette import BATTERY, INK
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.world.tiles import DROPOFF, EMPTY, PICKUP

TILE_PIXELS = 8
"""Side of a tile; the picture of the default layout has 64 x 96 pixels."""


class ObservationImage:
    """Paints observations, one or a batch.

    Args:
        height: rows of the layout, ``H``.
        width: columns, ``W``.
        battery: units of a full charge.
        max_steps: steps after which an episode is truncated.

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
        self._painter = TilePainter(TILE_PIXELS)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Height, width and channels of a picture, with one tile of height for the bars."""
        return (self._height + 1) * TILE_PIXELS, self._width * TILE_PIXELS, 3

    def paint(self, arrays: ObservationArrays) -> Pixels:
        """Return new pictures of observations: ``[..., (H + 1) * T, W * T, 3]`` uint8."""
        width, half = self._width * TILE_PIXELS, TILE_PIXELS // 2
        battery = bar(arrays["battery"][..., 0] / self._battery, width, half, BATTERY)
        steps = bar(arrays["steps"][..., 0] / self._max_steps, width, half, INK)
        return np.concatenate([self._painter.paint(self._known(arrays)), battery, steps], axis=-3)

    def _known(self, arrays: ObservationArrays) -> NDArray[np.uint8]:
        """Return the known codes of cells, ``[..., H, W]``."""
        batch = arrays["robot_pos"].shape[:-1]
        robots = arrays["robot_pos"].reshape(-1, 2)
        windows = arrays["local_grid"].reshape(len(robots), -1)
        side = math.isqrt(windows.shape[1])
        radius = side // 2
        size = (self._height + 2 * radius, self._width + 2 * radius)
        cells = np.full((len(robots), *size), CODES[UNSEEN, NO_ROBOT], np.uint8)
        each = np.arange(len(robots))
        rows, cols = (robots[:, axis, None] + np.arange(side) for axis in (0, 1))
        under = np.full(len(robots), CODES[EMPTY, NO_ROBOT])
        for tile, positions in ((PICKUP, arrays["pickup_pos"]), (DROPOFF, arrays["dropoff_pos"])):
            stations = positions.reshape(-1, 2)
            there = np.flatnonzero(stations[:, 0] >= 0)
            code = CODES[tile, NO_ROBOT]
            cells[there, stations[there, 0] + radius, stations[there, 1] + radius] = code
            under[(stations == robots).all(axis=1)] = code
        cells[each[:, None, None], rows[:, :, None], cols[:, None, :]] = windows.reshape(
            -1, side, side
        )
        loaded = np.asarray(arrays["has_item"]).reshape(-1)
        cells[each, robots[:, 0] + radius, robots[:, 1] + radius] = ROBOT_CODES[loaded, under]
        inner = cells[:, radius : radius + self._height, radius : radius + self._width]
        return inner.reshape(*batch, self._height, self._width)
