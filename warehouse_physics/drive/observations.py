"""What a robot under continuous control observes, as a vector or as a dict.

=============  ======  ======================================================  ==================
Key            Length  Meaning in the dict                                     Unit in the vector
=============  ======  ======================================================  ==================
``velocity``   2       speed ahead and to the right, m/s                       top speed
``turn_rate``  1       turn rate, rad/s; positive to the right                 half a turn per s
``heading``    2       cosine and sine of the heading; 1 and 0 face east       1
``position``   2       x and y, metres                                         ``SCAN_RANGE``
``goal``       2       metres ahead and to the right to the pickup, and with   ``SCAN_RANGE``
                       an item to the dropoff
``has_item``   1       1 if the robot carries an item                          1
``stood``      1       seconds for which the robot has stood where it can      ``spec.dwell``
                       pick or drop
``battery``    1       joules left                                             a full battery
``time_left``  1       seconds until the episode is truncated                  ``max_seconds``
``scan``       K       metres to the first obstacle along each ray. Ray 0 is   ``SCAN_RANGE``
                       straight ahead, and ray 1 is to the right of it.
=============  ======  ======================================================  ==================

A disc that is pushed in any direction never turns: for it, *ahead* is east and *to the right* is
south. With errors of the odometry, position, heading and goal are what the robot believes. All
values are limited to the bounds of the space.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from warehouse_core.arguments import one_of
from warehouse_core.motion.base import SCAN_RANGE
from warehouse_physics.drive.rows import DriveRows, DriveSettings
from warehouse_physics.profile import Floats

VECTOR, DICT = "vector", "dict"
DRIVE_FORMS = (VECTOR, DICT)

MOST_SPEED = 2.0
"""Largest speed in a space, in top speeds. Noise and pushes can make a robot faster than intended.
"""


class DriveForm:
    """The form of the observations of a robot with these settings.

    Attributes:
        space: space of the observation of one robot.
    """

    def __init__(self, name: str, settings: DriveSettings) -> None:
        self._is_dict = one_of("observation", name, DRIVE_FORMS) == DICT
        spec, layout = settings.spec, settings.layout
        size = np.array([layout.width, layout.height]) * spec.cell_size
        reach, fastest = math.hypot(*size), MOST_SPEED * spec.top_speed
        turning = MOST_SPEED * spec.top_speed / spec.wheel_arm
        # Name, lower and upper bound, and unit in a vector.
        table: tuple[tuple[str, Any, Any, float], ...] = (
            ("velocity", [-fastest] * 2, [fastest] * 2, spec.top_speed),
            ("turn_rate", [-turning], [turning], math.pi),
            ("heading", [-1.0] * 2, [1.0] * 2, 1.0),
            ("position", [0.0] * 2, size, SCAN_RANGE),
            ("goal", [-reach] * 2, [reach] * 2, SCAN_RANGE),
            ("has_item", [0.0], [1.0], 1.0),
            ("stood", [0.0], [spec.dwell + 1 / settings.rate], spec.dwell),
            ("battery", [0.0], [settings.battery], settings.battery),
            ("time_left", [0.0], [settings.max_seconds], settings.max_seconds),
            ("scan", [0.0] * settings.rays, [SCAN_RANGE] * settings.rays, SCAN_RANGE),
        )
        self._low, self._high = (
            np.concatenate([np.asarray(row[side], float) for row in table]) for side in (1, 2)
        )
        units = np.concatenate([np.full(len(row[1]), row[3]) for row in table])
        self._scale = 1 / units
        self._parts: dict[str, slice] = {}
        first = 0
        for name_of_part, low, *_ in table:
            self._parts[name_of_part] = slice(first, first := first + len(low))
        self._names = [name_of_part for name_of_part, low, *_ in table if len(low)]
        self.space: spaces.Space[Any] = (
            spaces.Dict({each: self._box(self._parts[each], 1.0) for each in self._names})
            if self._is_dict
            else self._box(slice(None), self._scale)
        )

    def of(self, rows: DriveRows) -> Any:
        """Return the observations of all robots: ``[B, L]`` float32, or a dict of such arrays."""
        numbers = np.clip(self._numbers(rows), self._low, self._high)
        if self._is_dict:
            return {each: numbers[:, self._parts[each]].astype(np.float32) for each in self._names}
        return (numbers * self._scale).astype(np.float32)

    def _box(self, part: slice, scale: Any) -> spaces.Box[Any]:
        low, high = (limits * scale for limits in (self._low, self._high))
        return spaces.Box(
            low[part].astype(np.float32), high[part].astype(np.float32), dtype=np.float32
        )

    def _numbers(self, rows: DriveRows) -> Floats:
        """Return all numbers in SI units, ``[B, L]``."""
        settings, state = rows.settings, rows.state
        numbers = np.empty((len(state.angles), len(self._low)))
        poses = rows.poses()
        believed = poses[:, 2]
        values: dict[str, NDArray[Any]] = {
            "velocity": in_frame(state.velocities, state.angles),
            "turn_rate": state.turn_rates[:, None],
            "heading": np.stack([np.cos(believed), np.sin(believed)], axis=1),
            "position": poses[:, :2],
            "goal": in_frame(rows.goals() - poses[:, :2], believed),
            "has_item": rows.has_item[:, None],
            "stood": rows.stood[:, None],
            "battery": rows.batteries[:, None],
            "time_left": settings.max_seconds - rows.seconds[:, None],
        }
        if settings.rays:
            values["scan"] = rows.scans()
        for name, value in values.items():
            numbers[:, self._parts[name]] = value
        return numbers


def in_frame(vectors: Floats, headings: Floats) -> Floats:
    """Return vectors ``[B, 2]`` as seen by robots: the part ahead and the part to the right."""
    cos, sin = np.cos(headings), np.sin(headings)
    right, down = vectors.T
    return np.stack([right * cos + down * sin, down * cos - right * sin], axis=1)
