"""Distances to walls along rays, for many robots at once.

A ray crosses the lines of the grid one after the other. The functions step from line to line, for
all rays together, and drop the rays that have met a wall.

Source: Amanatides and Woo (1987), A Fast Voxel Traversal Algorithm for Ray Tracing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import WALL

Floats = NDArray[np.float64]


class WallRays:
    """The walls of a layout, in a form in which rays meet them.

    Everything outside the layout counts as wall.

    Example:
        >>> import numpy as np
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> from warehouse_core.world.rays import WallRays
        >>> WallRays(DEFAULT_LAYOUT).distances(np.array([[1.5, 1.5]]), np.zeros((1, 1)), 20.0)
        array([[6.5]])
    """

    def __init__(self, layout: Layout) -> None:
        tiles = np.array([list(row) for row in layout.rows])
        self._is_wall = np.pad(tiles == WALL, 1, constant_values=True)
        self._width = self._is_wall.shape[1]

    def distances(self, positions: Floats, angles: Floats, reach: float) -> Floats:
        """Return the distance to the first wall along each ray, at most ``reach``.

        All lengths are in cells.

        Args:
            positions: ``[N, 2]``, x and y of the start of the rays, inside the layout.
            angles: ``[N, K]`` radians from the x axis towards the y axis.
            reach: largest distance.

        Returns:
            ``[N, K]`` distances.
        """
        shape = angles.shape
        ahead = np.stack([np.cos(angles), np.sin(angles)]).reshape(2, -1)
        start = np.repeat(positions.T, shape[1], axis=1)
        cells = np.floor(start)
        with np.errstate(divide="ignore"):
            apart = np.abs(1 / ahead)  # distance along the ray between two lines of one direction
        room = np.where(ahead > 0, cells + 1 - start, start - cells)
        # Rays along a line never cross it.
        nexts = np.where(np.isinf(apart), np.inf, room * apart)
        steps = np.where(ahead > 0, 1, -1) * np.array([[1], [self._width]])
        places = ((cells[1] + 1) * self._width + cells[0] + 1).astype(np.intp)
        is_wall = self._is_wall.ravel()
        distances = np.zeros(len(places))
        rays = np.arange(len(places))
        while len(rays):
            crosses_x = nexts[0] <= nexts[1]
            passed = np.where(crosses_x, nexts[0], nexts[1])
            places += np.where(crosses_x, steps[0], steps[1])
            nexts[0] += np.where(crosses_x, apart[0], 0.0)
            nexts[1] += np.where(crosses_x, 0.0, apart[1])
            goes_on = ~is_wall[places]
            distances[rays] = passed
            rays, places = rays[goes_on], places[goes_on]
            nexts, apart, steps = nexts[:, goes_on], apart[:, goes_on], steps[:, goes_on]
        return np.minimum(distances, reach).reshape(shape)
