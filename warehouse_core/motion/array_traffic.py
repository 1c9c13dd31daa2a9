"""The table of ``traffic.py`` for all robots of ``B`` floors at once, in NumPy arrays.

The floors are laid end to end, so that a cell is one number over all of them. An array leads from
a cell to a robot. It is never cleared: an old entry names a robot that is in another cell now.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.batch import NOTHING, WALL
from warehouse_core.motion.traffic import Obstacle, stop_by_robots
from warehouse_core.world.tables import Flags, Integers

Numbers = NDArray[np.intp]

MAX_SMALL_FLEET = 32
"""Up to this many robots are faster as lists, as each call of NumPy takes about a microsecond."""

MAX_SMALL_FRONT = 100
"""Queues up to this many are followed one by one, which is then faster than all together."""


class ArrayTraffic:
    """Finds what stops each of ``N`` robots; equal to ``find_stops`` on each floor.

    ``cells`` is their number on all floors together, ``robots`` their number on each floor.
    """

    def __init__(self, cells: int, floors: int, robots: int) -> None:
        self._robots = np.arange(floors * robots, dtype=np.intp)
        # WALL and NOTHING are negative indices, which count from the end.
        self._on_floor = np.array([*list(range(robots)) * floors, WALL, NOTHING], np.intp)
        self._robot_of = np.zeros(cells, np.intp)

    def find_stops(self, cells: Integers, targets: Integers, walled: Flags) -> Numbers:
        """Return ``[N]``: ``NOTHING``, ``WALL``, or the number of a robot on its floor.

        Targets are neighbours or the robots' own cells; their own for those at a wall, ``walled``.
        """
        if len(cells) <= MAX_SMALL_FLEET:
            return self._on_floor.take(_listed_stops(cells, targets, walled))
        stops = np.full(len(cells), NOTHING, np.intp)
        stops[walled] = WALL
        is_waiting = targets == cells
        movers = np.flatnonzero(~is_waiting)
        goals = targets.take(movers)
        self._robot_of[cells] = self._robots
        ahead = self._robot_of.take(goals)
        self._stop_rivals(stops, movers, goals)
        is_behind = (cells.take(ahead) == goals) & (stops.take(movers) == NOTHING)
        movers, ahead = _chosen(is_behind, movers, ahead)
        is_head_on = targets.take(ahead) == cells.take(movers)
        robots, others = _chosen(is_head_on, movers, ahead)
        stops[robots] = others
        robots, others = _chosen(~is_head_on, movers, ahead)
        _stop_queues(stops, is_waiting | (stops != NOTHING), robots, others)
        return self._on_floor.take(stops)

    def _stop_rivals(self, stops: Numbers, movers: Numbers, goals: Integers) -> None:
        """Stop movers with the same target: the first by the second, the others by the first."""
        self._robot_of[goals] = len(stops)
        np.minimum.at(self._robot_of, goals, movers)
        first = self._robot_of.take(goals)
        late, first = _chosen(first != movers, movers, first)
        stops[late] = first
        stops[first] = len(stops)
        np.minimum.at(stops, first, late)


def _listed_stops(cells: Integers, targets: Integers, walled: Flags) -> list[int]:
    """Return the stops of a few robots, numbered over all floors; see ``ArrayTraffic``."""
    stops: list[Obstacle] = [WALL if is_walled else None for is_walled in walled.tolist()]
    stop_by_robots(stops, cells.tolist(), targets.tolist())
    return [stop if isinstance(stop, int) else NOTHING for stop in stops]


def _stop_queues(stops: Numbers, is_still: Flags, followers: Numbers, ahead: Numbers) -> None:
    """Stop the followers of robots that stay, then theirs, and so on; ``stops`` is changed.

    Each of ``followers`` would move into the cell of the one ``ahead`` of it; no two have the same.
    """
    behind = np.full(len(stops), NOTHING, np.intp)
    behind[ahead] = followers
    front, ahead = _chosen(is_still.take(ahead), followers, ahead)
    while len(front) > MAX_SMALL_FRONT:
        stops[front] = ahead
        following = behind.take(front)
        front, ahead = _chosen(following != NOTHING, following, front)
    stop_of, behind_of = stops.data, behind.data
    for robot, other in zip(front.tolist(), ahead.tolist(), strict=True):
        while robot != NOTHING:
            stop_of[robot] = other
            robot, other = behind_of[robot], robot


def _chosen(flags: Flags, ones: Numbers, others: Numbers) -> tuple[Numbers, Numbers]:
    """Return the elements of two arrays at the flags; faster than indexing both by flags."""
    places = flags.nonzero()[0]
    return ones.take(places), others.take(places)
