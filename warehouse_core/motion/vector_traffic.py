"""The table of ``traffic.py`` for all robots of ``B`` floors at once, in NumPy arrays.

The floors are laid end to end, so that a cell is one number over all of them. An array leads from
a cell to a robot. It is never cleared: an old entry names a robot that is in another cell now.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.motion.vector import NOTHING, WALL, Flags, Integers

Numbers = NDArray[np.intp]

MAX_SMALL_FRONT = 64
"""Queues up to this many are followed one by one, which is then faster than all together."""


class VectorTraffic:
    """Finds what stops each of ``N`` robots; equal to ``find_stops`` on each floor.

    Args:
        cells: of all floors together.
        floors: ``B``.
        robots: on each floor, ``N / B``.
    """

    def __init__(self, cells: int, floors: int, robots: int) -> None:
        self._robots = np.arange(floors * robots)
        self._on_floor = np.tile(np.arange(robots), floors)
        self._robot_of = np.zeros(cells, np.intp)

    def find_stops(self, cells: Integers, targets: Integers, walled: Flags) -> Numbers:
        """Return ``[N]``: ``NOTHING``, ``WALL``, or the number of a robot on its floor.

        Args:
            cells: ``[N]``, all different.
            targets: ``[N]``, their own cells or neighbours; their own for those at a wall.
            walled: ``[N]``, whether the robot wants to move into a wall.
        """
        stops = np.where(walled, WALL, NOTHING)
        movers = np.flatnonzero(targets != cells)
        goals = targets.take(movers)
        self._robot_of[cells] = self._robots
        ahead = self._robot_of.take(goals)
        is_there = cells.take(ahead) == goals
        self._stop_rivals(stops, movers, goals)
        is_behind = is_there & (stops.take(movers) == NOTHING)
        movers, ahead = movers[is_behind], ahead[is_behind]
        head_on = targets.take(ahead) == cells.take(movers)
        stops[movers[head_on]] = ahead[head_on]
        is_still = (stops != NOTHING) | (targets == cells)
        _stop_queues(stops, is_still, movers[~head_on], ahead[~head_on])
        return np.where(stops < 0, stops, self._on_floor.take(stops))

    def _stop_rivals(self, stops: Numbers, movers: Integers, goals: Integers) -> None:
        """Stop movers with the same target: the first by the second, the others by the first."""
        self._robot_of[goals] = len(stops)
        np.minimum.at(self._robot_of, goals, movers)
        first = self._robot_of.take(goals)
        is_late = first != movers
        late, first = movers[is_late], first[is_late]
        stops[late] = first
        stops[first] = len(stops)
        np.minimum.at(stops, first, late)


def _stop_queues(stops: Numbers, is_still: Flags, followers: Integers, ahead: Integers) -> None:
    """Stop the followers of robots that stay, then theirs, and so on.

    Args:
        stops: ``[N]``, changed in place.
        is_still: ``[N]``, whether the robot stays.
        followers: the robots that move into a cell that another may leave, and
        ahead: for each of them the robot in that cell; no two follow the same robot.
    """
    is_stopped = is_still.take(ahead)
    behind = np.full(len(stops), NOTHING)
    behind[ahead] = followers
    front, ahead = followers[is_stopped], ahead[is_stopped]
    while len(front) > MAX_SMALL_FRONT:
        stops[front] = ahead
        following = behind.take(front)
        is_followed = following != NOTHING
        front, ahead = following[is_followed], front[is_followed]
    stop_of, behind_of = stops.data, behind.data
    for robot, other in zip(front.tolist(), ahead.tolist(), strict=True):
        while robot != NOTHING:
            stop_of[robot] = other
            robot, other = behind_of[robot], robot
