"""The motions that are compared: the grid, and bodies that are moved in three ways."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from warehouse_core.motion.backends import load_backend
from warehouse_core.motion.base import Motion
from warehouse_core.motion.grid import NOMINAL_SECONDS

PLAN, STOPPING, DRIVING, DISTURBED = "grid plan", "stopping", "driving through", "disturbed"

WORLDS = (PLAN, STOPPING, DRIVING, DISTURBED)
"""The names of the worlds: the plan on the grid, bodies that stop in every cell, bodies that drive
through, and these with disturbances."""


class Shocks(NamedTuple):
    """What happens in the world ``DISTURBED``.

    ``noise`` is the standard deviation of the speeds as a share of the commanded ones. For ``stop``
    seconds one robot stands still; with 0 none does, and with infinity it dies.
    """

    noise: float
    stop: float


class World(NamedTuple):
    """What makes the motion of a fleet, and the nominal seconds of a step."""

    motion: Callable[[], Motion]
    step_seconds: float


def make_world(name: str, shocks: Shocks, robots: int, busy_seconds: float, seed: int) -> World:
    """Return a world by name.

    A step of the grid and of robots that drive through lasts for the time of a cell at top speed.
    Where all robots stop in each cell, it lasts until the slowest is at rest: a loaded one.

    Args:
        name: one of ``WORLDS``.
        shocks: shocks in ``DISTURBED``.
        robots: number of robots, of which one is drawn to stop.
        busy_seconds: time in which orders come; in the first half of it the robot stops.
        seed: seed of what is drawn.
    """
    if name == PLAN:
        return World(load_backend("grid"), NOMINAL_SECONDS)
    if name == STOPPING:
        backend: Any = load_backend("physics")
        return World(backend, backend().spec.move_seconds(loaded=True))
    backend = load_backend("driving")
    if name == DRIVING:
        return World(backend, backend().period)
    from warehouse_physics import Disturbances, Stop

    stream = np.random.default_rng(seed)
    robot, at = int(stream.integers(robots)), float(stream.uniform(0, busy_seconds / 2))
    stops = (Stop(robot, at, shocks.stop),) if shocks.stop else ()
    disturbances = Disturbances(actuation_noise=shocks.noise, stops=stops)
    return World(lambda: backend(disturbances=disturbances), backend().period)
