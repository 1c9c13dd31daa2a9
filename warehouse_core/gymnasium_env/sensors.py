"""Sensors of a robot, which add keys to the chapter's observation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.errors import BackendError
from warehouse_core.motion.base import MAX_RAYS, SCAN_RANGE, with_defaults
from warehouse_core.warehouse_env import WarehouseEnv


class Sensors:
    """The sensors of an environment's robot, whose readings are keys of its observations.

    ============  =================================================================================
    ``scan``      ``[n]`` float32, distance in metres to the nearest wall in ``n`` directions, at
                  most ``SCAN_RANGE``. The first direction is east, and the second is further
                  towards south.
    ``odometry``  ``[3]`` float32, estimated x and y in metres and heading in radians. Present only
                  if the backend has odometry that drifts.
    ============  =================================================================================

    Args:
        env: environment of the robot, after a reset.
        scan: number of rays ``n``; 0 for no scan.
        observation: name of the form of the observations.

    Attributes:
        spaces: space of each key; empty for a robot without sensors.

    Raises:
        ValueError: the number of rays is not allowed, or the form of observations has no keys.
        BackendError: the backend does not support scans.
    """

    def __init__(self, env: WarehouseEnv, scan: int, observation: str) -> None:
        self._rays = whole_number("scan", scan, 0, MAX_RAYS)
        self.spaces: dict[str, spaces.Space[Any]] = {}
        self._motion = motion = with_defaults(env.motion)
        if self._rays:
            if motion.scan(0, self._rays) is None:
                raise BackendError(
                    f"scan is {scan}, but backend {env.backend!r} does not support scans; "
                    "allowed: 0, or a backend with a scan, such as 'physics'"
                )
            self.spaces["scan"] = spaces.Box(0.0, SCAN_RANGE, (self._rays,), np.float32)
        if motion.odometry(0) is not None:
            # A step is at most a cell long, and is never measured as three times as long.
            farthest = (max(env.height, env.width) + 3 * env.max_steps) * motion.cell_size
            limits = np.array([farthest, farthest, math.pi], np.float32)
            self.spaces["odometry"] = spaces.Box(-limits, limits, dtype=np.float32)
        if self.spaces and observation != "dict":
            raise ValueError(
                f"observation is {observation!r}; it must be 'dict' for {' and '.join(self.spaces)}"
            )

    def read(self) -> dict[str, NDArray[np.float32]]:
        """Return the current readings of the sensors as new arrays."""
        motion = self._motion
        sense = {"scan": lambda: motion.scan(0, self._rays), "odometry": lambda: motion.odometry(0)}
        return {key: np.array(sense[key](), np.float32) for key in self.spaces}
