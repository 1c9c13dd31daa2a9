"""A picture of a robot that is not in the middle of a cell, and of the things around it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pymunk
from numpy.typing import NDArray

from warehouse_core import Layout
from warehouse_core.motion.base import Pose
from warehouse_core.render.atlas import color_bytes
from warehouse_core.render.painter import TilePainter, codes_of
from warehouse_core.render.palette import BOARD, COLORS, INK
from warehouse_core.world.tiles import ROBOT_EMPTY, ROBOT_LOADED
from warehouse_physics.profile import Floats
from warehouse_physics.spec import RobotSpec

CORNERS = [pymunk.Vec2d(1, 0).rotated_degrees(angle) for angle in range(0, 360, 20)]
"""Unit vectors to the corners of the outline of a circle."""

NOSE = 0.3
"""Half the width of the line from the middle of a robot to its front, as a share of its radius."""


def picture_of(
    painter: TilePainter,
    layout: Layout,
    pose: Pose,
    has_item: bool,
    spec: RobotSpec,
    things: Iterable[pymunk.Shape] = (),
) -> NDArray[np.uint8]:
    """Return a picture ``[H, W, 3]`` of a layout with a robot at a pose, and with other shapes."""
    picture = painter.paint(codes_of(layout.rows))
    scale = painter.tile_pixels / spec.cell_size
    rows, columns = np.indices(picture.shape[:2])
    places = np.stack([columns + 0.5, rows + 0.5], axis=-1) / scale
    for shape in things:
        picture[depth(shape, places) >= 0] = color_bytes(BOARD)
    x, y, heading = pose
    right, down = np.moveaxis(places - (x, y), -1, 0)
    ahead = right * np.cos(heading) + down * np.sin(heading)
    aside = down * np.cos(heading) - right * np.sin(heading)
    is_inside = np.hypot(right, down) <= spec.radius
    picture[is_inside] = color_bytes(COLORS[ROBOT_LOADED if has_item else ROBOT_EMPTY])
    picture[is_inside & (ahead > 0) & (np.abs(aside) < NOSE * spec.radius)] = color_bytes(INK)
    return picture


def outlines_of(things: Iterable[pymunk.Shape]) -> Floats:
    """Return the outlines of shapes as straight lines ``[N, 4]``: x and y of both ends, in metres.

    A circle has ``CORNERS`` corners, and a segment is its middle line.
    """
    lines = [np.empty((0, 4))]
    for shape in things:
        if isinstance(shape, pymunk.Circle):
            corners = [shape.offset + shape.radius * turn for turn in CORNERS]
        elif isinstance(shape, pymunk.Segment):
            corners = [shape.a, shape.b]
        else:
            assert isinstance(shape, pymunk.Poly)
            corners = shape.get_vertices()
        places = _in_world(shape, corners)
        ends = np.roll(places, -1, axis=0)
        whole = slice(1) if len(corners) == 2 else slice(None)
        lines.append(np.hstack([places, ends])[whole])
    return np.concatenate(lines)


def depth(shape: pymunk.Shape, places: Floats) -> Floats:
    """Return how deep in a shape places ``[..., 2]`` are, in metres; negative outside."""
    if isinstance(shape, pymunk.Poly):
        corners = _in_world(shape, shape.get_vertices())
        edges = np.roll(corners, -1, axis=0) - corners
        offsets = places[..., None, :] - corners
        # pymunk lists the corners so that the inside is to the left of each edge.
        inside = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
        polygon: Floats = (inside / np.hypot(*edges.T)).min(axis=-1) + shape.radius
        return polygon
    if isinstance(shape, pymunk.Segment):
        start, end = _in_world(shape, [shape.a, shape.b])
        along = end - start
        share = np.clip((places - start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
        nearest = start + share[..., None] * along
        segment: Floats = shape.radius - np.hypot(*np.moveaxis(places - nearest, -1, 0))
        return segment
    assert isinstance(shape, pymunk.Circle)
    [middle] = _in_world(shape, [shape.offset])
    circle: Floats = shape.radius - np.hypot(*np.moveaxis(places - middle, -1, 0))
    return circle


def _in_world(shape: pymunk.Shape, points: Iterable[pymunk.Vec2d]) -> Floats:
    """Return points that are relative to the body of a shape as positions ``[N, 2]``."""
    assert shape.body is not None
    return np.array([shape.body.local_to_world(point) for point in points])
