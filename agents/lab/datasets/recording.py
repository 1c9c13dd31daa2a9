"""Recordings of episodes for robotics tools, in the MCAP format.

Times are simulated, in nanoseconds from the start of the episode, so that a record always gives the
same bytes with the same version of the library. Messages are JSON objects. The fields of messages
named ``foxglove.*`` follow Foxglove's schemas, so that its 3D panel can show them.

The frame ``warehouse`` has its origin at the north-west corner of the layout. Its x axis points
east, y north and z up, in metres. In the core the y axis points south. Therefore y and headings
change their signs here, because robotics tools expect right-handed frames.

Sources: https://mcap.dev/spec; https://github.com/foxglove/foxglove-sdk/tree/main/schemas/jsonschema;
for the axes REP 103, https://www.ros.org/reps/rep-0103.html
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warehouse_core import Episode
from warehouse_core.errors import FormatError
from warehouse_core.extras import install_command
from warehouse_core.files.atomic import atomic_path
from warehouse_core.motion.base import Contact, robot_contact
from warehouse_core.render.palette import COLORS, HIT, INK, Color
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Frame, Pose
from warehouse_core.wording import printable
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

MCAP = ".mcap"

POSE_SECONDS = 0.1
"""Seconds between two poses of a robot during a motion; tools interpolate between them."""

Message = dict[str, Any]

FRAME = "warehouse"

SHAPES = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
"""Names of the lists of shapes in a scene entity; the last four lists are always empty."""

SCENE = "foxglove.SceneUpdate"
LAYOUT, BODIES, POSES, HITS = "/layout", "/bodies", "/tf", "/hits"
CONTACTS, ENERGY = "/contacts", "/energy"

SCHEMA_OF = {
    **dict.fromkeys((LAYOUT, BODIES, HITS), SCENE),
    POSES: "foxglove.FrameTransforms",
    CONTACTS: "warehouse.Contact",
    ENERGY: "warehouse.Energy",
}
"""Name of the schema for each topic."""

HEIGHTS = {WALL: 0.5, PICKUP: 0.02, DROPOFF: 0.02, CHARGER: 0.02}
"""Height of each tile on the floor, in cells like the other sizes below."""

FLOOR = 0.02
DIAMETER, BODY, NOSE, HIT_SIZE = 0.62, 0.3, 0.25, 0.2
HIT_SECONDS = 0.6
"""Seconds for which a hit is shown."""


class Entry(NamedTuple):
    """A message of a recording, with its time in nanoseconds and its topic."""

    time: int
    topic: str
    message: Message


def save_recording(target: Path, record: Episode) -> None:
    """Write a record as an MCAP file, and leave no incomplete file after an error.

    Raises:
        FormatError: the package mcap is not installed.
        RecordError: the motions of the record take more than ``MAX_FRAMES`` frames.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise FormatError(f"saving as {MCAP} needs mcap: {install_command('mcap')}") from None
    with atomic_path(target) as part, part.open("wb") as file:
        writer = Writer(file)
        writer.start(library="warehouse-lab")
        writer.add_metadata("episode", _about(record))
        kinds = {
            name: writer.register_schema(name, "jsonschema", _json({"title": name, **schema}))
            for name, schema in schemas().items()
        }
        channels: dict[str, int] = {}
        for time, topic, message in entries(record):
            if topic not in channels:
                kind = kinds[SCHEMA_OF[topic]]
                channels[topic] = writer.register_channel(topic, "json", kind)
            writer.add_message(channels[topic], time, _json(message), time)
        writer.finish()


def entries(record: Episode) -> Iterator[Entry]:
    """Yield the messages of a record in the order of their times."""
    recording = _Recording(record)
    frames = track_of_record(record, POSE_SECONDS).frames
    yield Entry(0, LAYOUT, layout_scene(record.layout, recording.size))
    steps = groupby(frames, lambda frame: math.ceil(frame.progress))
    begin = math.nan  # the first frame does not belong to a step
    for step, found in steps:
        moments = list(found)
        yield from sorted(recording.step(step, begin, moments), key=lambda entry: entry.time)
        begin = moments[-1].clock


def contacts_of(record: Episode, step: int) -> Iterator[tuple[int, Contact]]:
    """Yield the number of the body and the contact for each contact in a step; step 0 has none.

    Bodies are numbered with the robots first and then the people, also as counterparts. The record
    of a fleet on the grid has no contacts.
    """
    if step and record.motions:
        motions = record.motions[step - 1]
        for body, motion in enumerate(motions if record.is_fleet else (motions,)):
            for contact in motion.contacts:
                yield body, contact


class _Recording:
    """The messages of a record, step by step."""

    def __init__(self, record: Episode) -> None:
        self._record = record
        self.size, robots = record.cell_size, record.robots
        if not record.is_fleet:
            people = 0
            joules = [[motion.joules] for motion in record.motions]
            self._battery = np.reshape(record.battery, (-1, 1))
        else:
            people, joules = record.people.shape[1], record.joules.tolist()
            self._battery = record.battery
        self._joules = np.cumsum([[0.0] * robots, *joules], axis=0)
        self._robots = robots
        self._names = [f"robot_{number}" for number in range(robots)]
        self._names += [f"person_{number}" for number in range(people)]
        self._name_of = {robot_contact(body): name for body, name in enumerate(self._names)}
        self._loads: dict[str, bool | None] = {}
        self._hits = 0

    def step(self, step: int, begin: float, frames: Sequence[Frame]) -> Iterator[Entry]:
        """Yield the messages of a step that began at ``begin`` seconds, in any order."""
        for frame in frames:
            yield from self._moment(frame)
        for body, contact in contacts_of(self._record, step):
            time, self._hits = _nanoseconds(begin + contact.seconds), self._hits + 1
            other = self._name_of.get(contact.counterpart, printable(contact.counterpart))
            message = contact_message(time, self._names[body], other, contact)
            yield Entry(time, CONTACTS, message)
            yield Entry(time, HITS, hit_scene(time, self._hits, contact, self.size))
        time = _nanoseconds(frames[-1].clock)
        joules, battery = self._joules[step].tolist(), self._battery[step].tolist()
        yield Entry(time, ENERGY, energy_message(time, step, joules, battery))

    def _moment(self, frame: Frame) -> Iterator[Entry]:
        """Yield the poses of a frame, and the shapes of the bodies if a load has changed."""
        time = _nanoseconds(frame.clock)
        named = zip(self._names, frame.robots, strict=True)
        poses = {name: pose for name, pose in named if pose is not None}
        yield Entry(time, POSES, transforms(time, poses, self.size))
        loads = {
            name: pose.loaded if number < self._robots else None
            for number, (name, pose) in enumerate(poses.items())
        }
        # If any load changes, all bodies are sent, because a viewer that jumps to a time reads only
        # the previous message.
        if loads != self._loads:
            self._loads = loads
            yield Entry(time, BODIES, bodies_scene(time, loads, self.size))


def _about(record: Episode) -> dict[str, str]:
    """Return the metadata of an episode."""
    seed = "" if record.seed is None else str(record.seed)
    about = {"agent": record.agent, "backend": record.backend, "seed": seed,
             "outcome": record.outcome}  # fmt: skip
    return {name: printable(text) for name, text in about.items()}


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 10**9)


def _json(value: Any) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()


def stamp(nanoseconds: int) -> Message:
    """Return a time or a duration as a message with ``sec`` and ``nsec``."""
    sec, nsec = divmod(nanoseconds, 10**9)
    return {"sec": sec, "nsec": nsec}


def transforms(time: int, poses: dict[str, Pose], size: float) -> Message:
    """Return the message with the poses of bodies by name, for cells of ``size`` metres."""
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
    """Return the scene of floor, walls, stations and chargers, for cells of ``size`` metres."""
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
    """Return the scene of all bodies by name; ``loads`` has ``None`` for people."""
    return _scene(*[_body(time, name, loaded, size) for name, loaded in loads.items()])


def hit_scene(time: int, number: int, contact: Contact, size: float) -> Message:
    """Return the scene with a mark for a contact, which is shown for ``HIT_SECONDS``."""
    x, y = contact.point
    sphere = _box(x, -y, BODY / 2 * size, (HIT_SIZE * size,) * 3, HIT)
    lifetime = round(HIT_SECONDS * 10**9)
    return _scene(_entity(time, FRAME, f"hit {number}", lifetime=lifetime, spheres=[sphere]))


def contact_message(time: int, robot: str, counterpart: str, contact: Contact) -> Message:
    """Return the message about a contact between a robot and a counterpart."""
    x, y = contact.point
    return {
        "timestamp": stamp(time), "robot": robot, "counterpart": counterpart,
        "impulse": _number(contact.impulse), "x": _number(x), "y": _number(-y),
    }  # fmt: skip


def energy_message(time: int, step: int, joules: list[float], battery: list[float]) -> Message:
    """Return the message about each robot's used energy and remaining battery after a step."""
    return {
        "timestamp": stamp(time), "step": step,
        "joules": list(map(_number, joules)), "battery": list(map(_number, battery)),
    }  # fmt: skip


def _body(time: int, name: str, loaded: bool | None, size: float) -> Message:
    """Return the scene entity of a body, which moves with the frame of the body."""
    tile = PERSON if loaded is None else ROBOT_LOADED if loaded else ROBOT_EMPTY
    side, tall, nose = DIAMETER * size, BODY * size, NOSE * size
    disc = _box(0, 0, tall / 2, (side, side, tall), COLORS[tile])
    cylinder = {**disc, "bottom_scale": 1, "top_scale": 1}
    arrow = {
        "pose": {"position": _vector(0, 0, tall), "orientation": _turned(0)},
        "shaft_length": _number(nose / 2), "shaft_diameter": _number(nose / 4),
        "head_length": _number(nose / 2), "head_diameter": _number(nose / 2),
        "color": _color(INK),
    }  # fmt: skip
    return _entity(time, name, name, locked=True, cylinders=[cylinder], arrows=[arrow])


def _scene(*entities: Message) -> Message:
    return {"deletions": [], "entities": list(entities)}


def _entity(
    time: int, frame: str, name: str, *, lifetime: int = 0, locked: bool = False, **shapes: Any
) -> Message:
    return {
        "timestamp": stamp(time), "frame_id": frame, "id": name, "lifetime": stamp(lifetime),
        "frame_locked": locked, "metadata": [], **{kind: [] for kind in SHAPES}, **shapes,
    }  # fmt: skip


def _box(x: float, y: float, z: float, sides: tuple[float, ...], color: Color) -> Message:
    pose = {"position": _vector(x, y, z), "orientation": _turned(0)}
    return {"pose": pose, "size": _vector(*sides), "color": _color(color)}


def _vector(x: float, y: float, z: float = 0.0) -> Message:
    return {"x": _number(x), "y": _number(y), "z": _number(z)}


def _turned(angle: float) -> Message:
    """Return a rotation about the z axis as a quaternion."""
    return {"x": 0, "y": 0, "z": _number(math.sin(angle / 2)), "w": _number(math.cos(angle / 2))}


def _color(color: Color) -> Message:
    return {**dict(zip("rgb", color, strict=True)), "a": 1}


def _number(value: float) -> float:
    """Round a number to six decimals, which are micrometres of a position, and -0.0 to 0.0."""
    return round(float(value), 6) + 0.0


def schemas() -> dict[str, Message]:
    """Return the JSON schema of each kind of message by name, derived from an example."""
    box = _box(0, 0, 0, (1, 1, 1), INK)
    body = _body(0, "", False, 1)
    scene = _scene({**body, "cubes": [box], "spheres": [box]})
    contact = contact_message(0, "", "", Contact(0, 0, (0, 0), ""))
    examples = {
        SCENE: scene | {"deletions": [{}]},
        SCHEMA_OF[POSES]: transforms(0, {"": Pose((0, 0), 0, loaded=False)}, 1),
        SCHEMA_OF[CONTACTS]: contact,
        SCHEMA_OF[ENERGY]: energy_message(0, 0, [0], [0]),
    }
    return {name: schema_of(example) for name, example in examples.items()}


def schema_of(value: Any, name: str = "") -> Message:
    """Return the JSON schema that describes an example value of the field ``name``."""
    match value:
        case {"sec": _, "nsec": _}:
            title = "duration" if name == "lifetime" else "time"
            return {"title": title, **_schema_of_object(value)}
        case dict():
            return _schema_of_object(value)
        case list():
            return {"type": "array", "items": schema_of(value[0] if value else {})}
        case bool():
            return {"type": "boolean"}
        case str():
            return {"type": "string"}
    return {"type": "integer" if name in ("sec", "nsec", "step") else "number"}


def _schema_of_object(value: Message) -> Message:
    properties = {name: schema_of(each, name) for name, each in value.items()}
    return {"type": "object", "properties": properties, "required": [*value]}
