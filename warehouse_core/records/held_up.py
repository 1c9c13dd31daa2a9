"""The steps in which the robots of a fleet were held up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.base import NOTHING
from warehouse_core.records.episode import FleetEpisode
from warehouse_core.world.actions import WAIT


def held_up(episode: FleetEpisode) -> NDArray[np.bool_]:
    """Return for each step and robot of a fleet whether the robot was held up, as ``[T, R]``.

    A robot is held up if it is blocked, or if it turns back into the cell that it has just left. It
    is also held up if it waits although it has an order, unless it is on a charger. In episodes
    without orders every wait counts.
    """
    layout, cells = episode.layout, episode.cells
    chargers = layout.numbers(layout.chargers)
    waits = (episode.counted_actions() == WAIT) & ~np.isin(cells[:-1], chargers)
    found: NDArray[np.bool_] = waits & _has_order(episode) | (episode.stopped_by != NOTHING)
    found[1:] |= (cells[2:] == cells[:-2]) & (cells[1:-1] != cells[2:])
    return found


def _has_order(episode: FleetEpisode) -> NDArray[np.bool_]:
    """Return for each step and robot whether the robot carries an order or is assigned to one.

    If the record has no assignments, each order counts as assigned, from its release on, to the
    robot that picked it up.
    """
    if episode.settings.orders is None:
        return np.ones(episode.actions.shape, np.bool_)
    found: NDArray[np.bool_] = episode.loaded[:-1].copy()
    if not episode.assignments:
        for order in episode.orders:
            if order.taken is not None:
                found[order.released : order.taken, order.taken_by] = True
        return found
    for step, robot, number in episode.assignments:
        found[step:, robot] = episode.loaded[step:-1, robot]
        if number is not None:
            found[step : episode.orders[number].taken, robot] = True
    return found
