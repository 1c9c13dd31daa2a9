"""What the robots of a fleet spend their time on, read from a record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core import FleetEpisode
from warehouse_core.motion.grid import NOMINAL_SECONDS
from warehouse_core.world.actions import DROP, PICK

KINDS = (
    "driving, at top speed",
    "speeding up, braking, turning",
    "waiting with an order",
    "picking, dropping, charging",
    "idle without an order",
)
"""Kinds of spent time. The first is the time that the distance would take at top speed, the second
the time that moving takes beyond it. Waiting is for other robots, for the end of a joint step, or
for a stop to end."""

AT_REST = 1e-4, 1e-3
"""Metres and radians between two rows of a path; with less of both a robot is at rest."""

Times = NDArray[np.float64]


def time_spent(episode: FleetEpisode, top_speed: float) -> Times:
    """Return the seconds that all robots together have spent on each of ``KINDS``.

    They add up to the number of robots times the simulated time. The top speed is in m/s. Of the
    orders of the record those count that an agent has assigned.
    """
    steps = episode.seconds.max(axis=1, initial=0.0)[:, None]
    moving, metres = _motion(episode)
    driving = metres / top_speed
    handles = _handles(episode, steps)
    charges = np.diff(episode.battery, axis=0) > 0
    own = np.where(charges, steps, np.where(handles, episode.seconds, moving))
    handling = np.maximum(own - moving, 0.0)
    resting = steps - moving - handling
    has_order = _has_order(episode)
    parts = (driving, moving - driving, resting * has_order, handling, resting * ~has_order)
    return np.array([part.sum() for part in parts])


def _handles(episode: FleetEpisode, steps: Times) -> NDArray[np.bool_]:
    """Return whether each robot picks or drops in each step, ``[T, R]``.

    Where steps are shorter than ``NOMINAL_SECONDS``, it goes on with it in the next.
    """
    begins = np.isin(episode.counted_actions(), (PICK, DROP))
    found, shortest = begins.copy(), float(steps.min(initial=NOMINAL_SECONDS))
    for later in range(1, round(NOMINAL_SECONDS / shortest)):
        found[later:] |= begins[:-later]
    return found


def _motion(episode: FleetEpisode) -> tuple[Times, Times]:
    """Return for how many seconds each robot moved in each step, and how far, ``[T, R]``."""
    if not episode.motions:
        moved = np.diff(episode.cells, axis=0) != 0
        return np.where(moved, episode.seconds, 0.0), moved * episode.cell_size
    found = np.zeros((2, *episode.seconds.shape))
    for step, outcomes in enumerate(episode.motions):
        for robot in range(episode.robots):
            seconds, x, y, heading = np.diff(outcomes[robot].path, axis=0).T
            lengths = np.hypot(x, y)
            is_moving = (lengths > AT_REST[0]) | (np.abs(heading) > AT_REST[1])
            found[:, step, robot] = seconds[is_moving].sum(), lengths[is_moving].sum()
    return found[0], found[1]


def _has_order(episode: FleetEpisode) -> NDArray[np.bool_]:
    """Return whether each robot has an order in each step, ``[T, R]``."""
    given: dict[int, list[tuple[int, bool]]] = {}
    for step, robot, order in episode.assignments:
        given.setdefault(step, []).append((robot, order is not None))
    found: NDArray[np.bool_] = episode.loaded[:-1].copy()
    has_order = np.zeros(episode.robots, np.bool_)
    for step in range(episode.steps):
        for robot, is_order in given.get(step, ()):
            has_order[robot] = is_order
        found[step] |= has_order
        has_order &= ~(episode.loaded[step] & ~episode.loaded[step + 1])
    return found
