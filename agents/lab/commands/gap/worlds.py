"""The motions that are compared: the grid, and bodies that are moved in four ways."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from agents.lab.commands.gap.alone import OwnFloors
from warehouse_core.motion.backends import load_backend
from warehouse_core.motion.base import Motion
from warehouse_core.motion.grid import NOMINAL_SECONDS

if TYPE_CHECKING:  # loading pymunk takes long
    from warehouse_physics import Disturbances

PLAN, STOPPING, ALONE, DRIVING, DISTURBED = (
    "grid plan",
    "stopping",
    "each robot alone",
    "driving through",
    "disturbed",
)

WORLDS = (PLAN, STOPPING, ALONE, DRIVING, DISTURBED)
"""The names of the worlds: the plan on the grid, bodies that stop in every cell, bodies that drive
through and meet nobody, bodies that drive through, and these with disturbances."""


STEPS_OF_A_CELL = 4
"""Steps in which a robot that drives through crosses a cell. With one, ways would grow no faster
than they are driven, so that corners would be known too late, and robots that have come to rest
would wait for the next step."""


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

    A step of the grid lasts for the time of a cell at top speed, and has ``STEPS_OF_A_CELL`` steps
    of robots that drive through. Where all robots stop in each cell, a step lasts until the slowest
    is at rest: a loaded one.

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
    period = backend().period / STEPS_OF_A_CELL
    if name == ALONE:
        return World(lambda: OwnFloors(backend(period=period)), period)
    if name == DRIVING:
        return World(partial(backend, period=period), period)
    disturbances = draw_disturbances(shocks, robots, busy_seconds, seed)
    return World(partial(backend, disturbances=disturbances, period=period), period)


def draw_disturbances(shocks: Shocks, robots: int, busy_seconds: float, seed: int) -> Disturbances:
    """Return the disturbances of shocks; see ``make_world``."""
    from warehouse_physics import Disturbances, Stop

    stream = np.random.default_rng(seed)
    robot, at = int(stream.integers(robots)), float(stream.uniform(0, busy_seconds / 2))
    stops = (Stop(robot, at, shocks.stop),) if shocks.stop else ()
    return Disturbances(actuation_noise=shocks.noise, stops=stops)
