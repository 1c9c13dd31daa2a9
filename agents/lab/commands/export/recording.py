"""An episode as a recording for robotics tools, in the format MCAP.

Times are simulated, in nanoseconds from the start of the episode, so that a record always gives the
same bytes with the same version of the library.

Source of the format: https://mcap.dev/spec
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.lab.commands.export.messages import (
    Message,
    bodies_scene,
    contact_message,
    energy_message,
    hit_scene,
    layout_scene,
    transforms,
)
from agents.lab.commands.export.schemas import (
    BODIES,
    CONTACTS,
    ENERGY,
    HITS,
    LAYOUT,
    POSES,
    SCHEMA_OF,
    SCHEMAS,
)
from warehouse_core import Episode
from warehouse_core.errors import FormatError
from warehouse_core.extras import install_command
from warehouse_core.files.atomic import atomic_path
from warehouse_core.motion.base import (
    NOTHING,
    WALL,
    WALL_CONTACT,
    Contact,
    centre_of,
    robot_contact,
)
from warehouse_core.motion.grid import NOMINAL_KG, NOMINAL_SECONDS
from warehouse_core.viz.export import progress_bar
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Frame
from warehouse_core.wording import printable
from warehouse_core.world.actions import DISPLACEMENTS

MCAP = ".mcap"

POSE_SECONDS = 0.1
"""Time between two poses of a robot inside a motion; tools interpolate."""


class Entry(NamedTuple):
    """A message of a recording, its time in nanoseconds and its topic."""

    time: int
    topic: str
    message: Message


def save_recording(target: Path, record: Episode) -> None:
    """Write a record as MCAP, whole or not at all.

    Raises:
        FormatError: mcap is not installed.
        RecordError: its motions take more than ``MAX_FRAMES`` frames.
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
            for name, schema in SCHEMAS.items()
        }
        channels: dict[str, int] = {}
        for time, topic, message in entries(record):
            if topic not in channels:
                kind = kinds[SCHEMA_OF[topic]]
                channels[topic] = writer.register_channel(topic, "json", kind)
            writer.add_message(channels[topic], time, _json(message), time)
        writer.finish()


def entries(record: Episode) -> Iterator[Entry]:
    """Yield the messages of a record in order of time."""
    recording = _Recording(record)
    frames = track_of_record(record, POSE_SECONDS).frames
    yield Entry(0, LAYOUT, layout_scene(record.layout, recording.size))
    steps = groupby(frames, lambda frame: math.ceil(frame.progress))
    with progress_bar(len(frames), "recording") as progress:
        begin, done = math.nan, 0  # the first frame is of no step
        for step, found in steps:
            moments = list(found)
            yield from sorted(recording.step(step, begin, moments), key=lambda entry: entry.time)
            begin, done = moments[-1].clock, done + len(moments)
            progress(done - 1, None)


def contacts_of(record: Episode, step: int) -> Iterator[tuple[int, Contact]]:
    """Yield the contacts in a step, and for each the body that it is of; step 0 has none.

    Bodies are the robots and then the people, which are numbered on as counterparts too.
    """
    if step == 0:
        return
    if not record.motions:
        yield from _nominal(record, step - 1)
        return
    motions = record.motions[step - 1]
    for body, motion in enumerate(motions if record.is_fleet else (motions,)):
        for contact in motion.contacts:
            yield body, contact


def _nominal(record: Episode, step: int) -> Iterator[tuple[int, Contact]]:
    """Yield the contacts of ``GridMotion``, which a fleet's record does not keep."""
    size, actions = record.cell_size, record.counted_actions(step)
    for robot in np.flatnonzero(record.stopped_by[step] != NOTHING).tolist():
        by = int(record.stopped_by[step, robot])
        down, right = DISPLACEMENTS[actions[robot]]
        x, y = centre_of(record.layout.cell(record.cells[step, robot]), size)
        yield (
            robot,
            Contact(
                NOMINAL_SECONDS / 2,
                NOMINAL_KG * size / NOMINAL_SECONDS,
                (x + right * size / 2, y + down * size / 2),
                WALL_CONTACT if by == WALL else robot_contact(by),
            ),
        )


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
        """Yield the messages of a step that began at ``begin`` seconds, in no order."""
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
        # All of them if any changes, because a viewer that jumps to a time reads the last message.
        if loads != self._loads:
            self._loads = loads
            yield Entry(time, BODIES, bodies_scene(time, loads, self.size))


def _about(record: Episode) -> dict[str, str]:
    """Return what the recording says of the episode as a whole."""
    about = {
        "agent": record.agent,
        "backend": record.backend,
        "seed": "" if record.seed is None else str(record.seed),
        "outcome": record.outcome,
    }
    return {name: printable(text) for name, text in about.items()}


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 10**9)


def _json(value: Any) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()
