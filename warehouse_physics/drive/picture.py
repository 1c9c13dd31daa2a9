"""A picture of a robot that is not in the middle of a cell, with NumPy only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core import Layout
from warehouse_core.motion.base import Pose
from warehouse_core.render.atlas import color_bytes
from warehouse_core.render.painter import TilePainter, layout_codes
from warehouse_core.render.palette import COLORS, INK
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED
from warehouse_physics.spec import RobotSpec

NOSE = 0.3
"""Half the width of the line from the middle of a robot to its front, as a share of its radius."""


def picture_of(
    painter: TilePainter, layout: Layout, pose: Pose, has_item: bool, spec: RobotSpec
) -> NDArray[np.uint8]:
    """Return a picture ``[H, W, 3]`` of a layout with a robot at a pose."""
    picture = painter.paint(layout_codes(layout))
    scale = painter.tile_pixels / spec.cell_size
    x, y, heading = pose
    rows, columns = np.indices(picture.shape[:2])
    right, down = (columns + 0.5) / scale - x, (rows + 0.5) / scale - y
    ahead = right * np.cos(heading) + down * np.sin(heading)
    aside = down * np.cos(heading) - right * np.sin(heading)
    is_inside = np.hypot(right, down) <= spec.radius
    picture[is_inside] = color_bytes(COLORS[ROBOT_LOADED if has_item else ROBOT_EMPTY])
    picture[is_inside & (ahead > 0) & (np.abs(aside) < NOSE * spec.radius)] = color_bytes(INK)
    return picture
