"""What a robot with sensors observes beyond the chapter's keys."""

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
    """The sensors of the robot of an environment, as keys of its observations.

    ============  =================================================================================
    ``scan``      ``[n]`` float32 metres to the nearest wall in ``n`` directions: the first leads
                  east, the others follow towards south; at most ``SCAN_RANGE``
    ``odometry``  ``[3]`` float32, x and y in metres and heading in radians that the robot believes
                  in, where its backend has odometry that drifts
    ============  =================================================================================

    Args:
        env: environment of the robot, after a reset.
        scan: number of rays, ``n``; 0 for no scan.
        observation: name of the form of the observations.

    Attributes:
        spaces: space of each key; empty without sensors.

    Raises:
        ValueError: a number of rays that is not allowed, a backend that cannot scan
            (``BackendError``), or a form without keys.
    """

    def __init__(self, env: WarehouseEnv, scan: int, observation: str) -> None:
        self._rays = whole_number("scan", scan, 0, MAX_RAYS)
        self.spaces: dict[str, spaces.Space[Any]] = {}
        self._motion = motion = with_defaults(env.motion)
        if self._rays:
            if motion.scan(0, self._rays) is None:
                raise BackendError(
                    f"scan is {scan}, but backend {env.backend!r} has no bodies to be seen; "
                    "allowed: 0, or a backend with a scan, such as 'physics'"
                )
            self.spaces["scan"] = spaces.Box(0.0, SCAN_RANGE, (self._rays,), np.float32)
        if motion.odometry(0) is not None:
            # No step is longer than a cell, nor measured as three times as long.
            farthest = (max(env.height, env.width) + 3 * env.max_steps) * motion.cell_size
            limits = np.array([farthest, farthest, math.pi], np.float32)
            self.spaces["odometry"] = spaces.Box(-limits, limits, dtype=np.float32)
        if self.spaces and observation != "dict":
            raise ValueError(
                f"observation is {observation!r}; it must be 'dict' for {' and '.join(self.spaces)}"
            )

    def read(self) -> dict[str, NDArray[np.float32]]:
        """Return what the robot senses now, as fresh arrays."""
        motion = self._motion
        sense = {"scan": lambda: motion.scan(0, self._rays), "odometry": lambda: motion.odometry(0)}
        return {key: np.array(sense[key](), np.float32) for key in self.spaces}
