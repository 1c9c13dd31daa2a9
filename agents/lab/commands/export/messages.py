"""The messages of a recording, as JSON objects.

The frame ``warehouse`` has its origin at the north-west corner of the layout, x east, y north and z
up, in metres. The core's y axis leads south, so that y and headings change their signs here:
robotics tools expect right-handed frames.

Source of the axes: REP 103, https://www.ros.org/reps/rep-0103.html
"""

from __future__ import annotations

import math
import re
from typing import Any

from agents.lab.commands.export.schemas import PRIMITIVES
from warehouse_core.motion.base import Contact
from warehouse_core.render.palette import COLORS, HIT, INK, Color
from warehouse_core.viz.tracks.track import Pose
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import (
    CHARGER,
    DROPOFF,
    EMPTY,
    PERSON,
    PICKUP,
    ROBOT_EMPTY,
    ROBOT_LOADED,
    WALL,
)

Message = dict[str, Any]

FRAME = "warehouse"

HEIGHTS = {WALL: 0.5, PICKUP: 0.02, DROPOFF: 0.02, CHARGER: 0.02}
"""Heights of the tiles that are drawn on the floor, in cells; so are all sizes here."""

FLOOR = 0.02
DIAMETER, BODY, NOSE, HIT_SIZE = 0.62, 0.3, 0.25, 0.2
HIT_SECONDS = 0.6
"""Time for which a hit is shown."""


def stamp(nanoseconds: int) -> Message:
    """Return a time or a duration."""
    sec, nsec = divmod(nanoseconds, 10**9)
    return {"sec": sec, "nsec": nsec}


def transforms(time: int, poses: dict[str, Pose], size: float) -> Message:
    """Return the frames of bodies at a time, by their names, in cells of ``size`` metres."""
    return {
        "transforms": [
            {
                "timestamp": stamp(time),
                "parent_frame_id": FRAME,
                "child_frame_id": name,
                "translation": _vector(pose.at[0] * size, -pose.at[1] * size),
                "rotation": _turned(-(pose.heading or 0.0)),
            }
            for name, pose in poses.items()
        ]
    }


def layout_scene(layout: Layout, size: float) -> Message:
    """Return floor, walls, stations and chargers, in cells of ``size`` metres."""
    height, width = layout.height * size, layout.width * size
    below = -FLOOR * size
    floor = _box(width / 2, -height / 2, below / 2, (width, height, -below), COLORS[EMPTY])
    boxes = [floor]
    for row, tiles in enumerate(layout.rows):
        for run in re.finditer(r"(\S)\1*", tiles):
            if tall := HEIGHTS.get(run[1], 0.0) * size:
                x, y = (run.start() + run.end()) / 2 * size, -(row + 0.5) * size
                sides = len(run[0]) * size, size, tall
                boxes.append(_box(x, y, tall / 2, sides, COLORS[run[1]]))
    return _scene(_entity(0, FRAME, "layout", cubes=boxes))


def bodies_scene(time: int, loads: dict[str, bool | None], size: float) -> Message:
    """Return the shapes of bodies by name: robots, loaded or not, and people (``None``)."""
    return _scene(*[_body(time, name, loaded, size) for name, loaded in loads.items()])


def hit_scene(time: int, number: int, contact: Contact, size: float) -> Message:
    """Return a mark of a contact that is shown for ``HIT_SECONDS``."""
    x, y = contact.point
    sphere = _box(x, -y, BODY / 2 * size, (HIT_SIZE * size,) * 3, HIT)
    lifetime = round(HIT_SECONDS * 10**9)
    return _scene(_entity(time, FRAME, f"hit {number}", lifetime=lifetime, spheres=[sphere]))


def contact_message(time: int, robot: str, counterpart: str, contact: Contact) -> Message:
    """Return a contact of a robot with a counterpart."""
    x, y = contact.point
    return {
        "timestamp": stamp(time),
        "robot": robot,
        "counterpart": counterpart,
        "impulse": _number(contact.impulse),
        "x": _number(x),
        "y": _number(-y),
    }


def energy_message(time: int, step: int, joules: list[float], battery: list[float]) -> Message:
    """Return what the robots have used and have left after a step."""
    return {
        "timestamp": stamp(time),
        "step": step,
        "joules": [_number(value) for value in joules],
        "battery": [_number(value) for value in battery],
    }


def _body(time: int, name: str, loaded: bool | None, size: float) -> Message:
    """Return the shape of a body, which moves with its frame."""
    tile = PERSON if loaded is None else ROBOT_LOADED if loaded else ROBOT_EMPTY
    side, tall, nose = DIAMETER * size, BODY * size, NOSE * size
    disc = _box(0, 0, tall / 2, (side, side, tall), COLORS[tile])
    cylinder = {**disc, "bottom_scale": 1, "top_scale": 1}
    arrow = {
        "pose": {"position": _vector(0, 0, tall), "orientation": _turned(0)},
        "shaft_length": _number(nose / 2),
        "shaft_diameter": _number(nose / 4),
        "head_length": _number(nose / 2),
        "head_diameter": _number(nose / 2),
        "color": _color(INK),
    }
    return _entity(time, name, name, locked=True, cylinders=[cylinder], arrows=[arrow])


def _scene(*entities: Message) -> Message:
    return {"deletions": [], "entities": list(entities)}


def _entity(
    time: int, frame: str, name: str, *, lifetime: int = 0, locked: bool = False, **shapes: Any
) -> Message:
    return {
        "timestamp": stamp(time),
        "frame_id": frame,
        "id": name,
        "lifetime": stamp(lifetime),
        "frame_locked": locked,
        "metadata": [],
        **{kind: [] for kind in PRIMITIVES},
        **shapes,
    }


def _box(x: float, y: float, z: float, sides: tuple[float, ...], color: Color) -> Message:
    pose = {"position": _vector(x, y, z), "orientation": _turned(0)}
    return {"pose": pose, "size": _vector(*sides), "color": _color(color)}


def _vector(x: float, y: float, z: float = 0.0) -> Message:
    return {"x": _number(x), "y": _number(y), "z": _number(z)}


def _turned(angle: float) -> Message:
    """Return a turn about the z axis as a quaternion."""
    return {"x": 0, "y": 0, "z": _number(math.sin(angle / 2)), "w": _number(math.cos(angle / 2))}


def _color(color: Color) -> Message:
    return {**dict(zip("rgb", color, strict=True)), "a": 1}


def _number(value: float) -> float:
    """Return a number with six decimals, micrometres of a position, and no negative zero."""
    return round(float(value), 6) + 0.0
