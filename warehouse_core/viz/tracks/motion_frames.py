"""The frames of continuous motions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from warehouse_core.arguments import real_number
from warehouse_core.errors import RecordError
from warehouse_core.motion.base import Contact, Outcome
from warehouse_core.viz.tracks.track import Frame, Hit, Pose

FRAME_SECONDS = 0.2
"""Simulated seconds from one frame of a continuous motion to the next."""

FLASH_SECONDS = 0.6
"""Simulated seconds for which a hit is shown."""

MAX_FRAMES = 100_000
"""Limit on the frames of continuous motions, whose number follows from their duration."""


def frames_along(
    start: Frame,
    motions: Sequence[Outcome],
    loaded: Sequence[bool],
    cell_size: float,
    frame_seconds: float,
    caption: str,
) -> Iterator[Frame]:
    """Yield the frames along the paths of one action of each robot, the last where they end.

    Args:
        start: the frame before.
        motions: for each robot of ``start`` what its backend did.
        loaded: for each robot whether it holds an item after the action.
        cell_size: in metres.
        frame_seconds: simulated time between two frames.
        caption: of each frame.
    """
    seconds, joules = max(motion.seconds for motion in motions), motions[0].joules
    count = max(1, round(seconds / frame_seconds))
    times = [seconds * frame / count for frame in range(count + 1)]
    paths = [
        [np.interp(times, motion.path[:, 0], motion.path[:, axis]).tolist() for axis in (1, 2, 3)]
        for motion in motions
    ]
    (xs, ys, _), *_ = paths
    for k in range(1, count + 1):
        is_last = k == count
        poses = [
            Pose(
                (x[k] / cell_size, y[k] / cell_size),
                angle[k],
                after if is_last else before is not None and before.loaded,
            )
            for (x, y, angle), before, after in zip(paths, start.robots, loaded, strict=True)
        ]
        hits = [
            hit_of(contact, cell_size, f"{contact.impulse:.0f} N·s", robot)
            for robot, motion in enumerate(motions)
            for contact in motion.contacts
            if contact.seconds <= times[k] <= contact.seconds + FLASH_SECONDS
        ]
        moved = math.dist((xs[k - 1], ys[k - 1]), (xs[k], ys[k]))
        yield Frame(
            start.tiles,
            tuple(poses),
            start.progress + k / count,
            caption,
            tuple({hit.at: hit for hit in hits}.values()),  # both robots of a collision report it
            start.clock + (seconds if is_last else times[k]),
            moved / (times[k] - times[k - 1]),
            start.energy + joules * k / count,
        )


def hit_of(contact: Contact, cell_size: float, label: str, robot: int = 0) -> Hit:
    """Return what is shown of a contact, whose point is in metres."""
    x, y = contact.point
    return Hit((x / cell_size, y / cell_size), label, robot)


def check_frame_seconds(frame_seconds: float | None, seconds: float) -> None:
    """Raise unless motions of so many seconds can have a frame every ``frame_seconds``.

    Raises:
        ValueError: ``frame_seconds`` is not a positive finite number.
        RecordError: they would take more than ``MAX_FRAMES`` frames.
    """
    if frame_seconds is None:
        return
    real_number("frame_seconds", frame_seconds, above=True)
    if seconds > MAX_FRAMES * frame_seconds:
        raise RecordError(
            f"the motions take {seconds:g} s; with a frame every {frame_seconds:g} s "
            f"that is more than MAX_FRAMES = {MAX_FRAMES}"
        )
