"""What a body measured in an episode: time, energy, distance, speed, stops and hits."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warehouse_core.arguments import instance_of
from warehouse_core.records.episode import Episode

AT_REST = 1e-3
"""Speed in m/s below which a body is at rest. Solvers may leave a small speed after a hit."""


class DriveSummary(NamedTuple):
    """What the body of a lone robot measured in an episode.

    Attributes:
        seconds: duration of all motions.
        joules: energy that all motions used.
        distance: distance driven in metres, measured along the path.
        top_speed: highest speed in m/s.
        stops: number of times that the body came to rest, including the last time. A pick or a wait
            after a move belongs to the stop at the end of the move.
        hits: number of contacts with walls or other bodies.
        largest_impulse: largest impulse of these contacts in N·s, or 0 without contacts.

    Example:
        >>> from warehouse_core.records import DriveSummary
        >>> DriveSummary._fields[:4]
        ('seconds', 'joules', 'distance', 'top_speed')
    """

    seconds: float
    joules: float
    distance: float
    top_speed: float
    stops: int
    hits: int
    largest_impulse: float


def drive_summary(episode: Episode) -> DriveSummary | None:
    """Return what the body measured in an episode.

    Returns:
        The summary; ``None`` for a fleet, and if a motion has no ``readings``, as on the grid.

    Raises:
        TypeError: ``episode`` is not an ``Episode``.

    Example:
        >>> from agents import GreedyAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> from warehouse_core.records import drive_summary
        >>> episode = record_episode(WarehouseEnv(backend="physics"), GreedyAgent(seed=12), seed=12)
        >>> summary = drive_summary(episode)
        >>> summary.stops, summary.hits, round(summary.distance), round(summary.top_speed, 2)
        (21, 0, 21, 1.0)
    """
    instance_of("episode", episode, Episode)
    motions = [] if episode.is_fleet else episode.motions
    readings = [motion.readings for motion in motions if motion.readings is not None]
    if not motions or len(readings) < len(motions):
        return None
    speeds = np.concatenate([np.hypot(*rows[:, :2].T) for rows in readings])
    is_driving = speeds > AT_REST
    steps = np.vstack([np.diff(motion.path[:, 1:3], axis=0) for motion in motions])
    impulses = [contact.impulse for motion in motions for contact in motion.contacts]
    return DriveSummary(
        episode.seconds,
        episode.joules,
        math.fsum(np.hypot(*steps.T)),
        float(speeds.max()),
        int((is_driving[:-1] & ~is_driving[1:]).sum()),
        len(impulses),
        max(impulses, default=0.0),
    )
