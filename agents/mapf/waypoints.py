"""Waypoints: near goals in place of distant ones, so that few goals need a distance field.

A distance field of 70,000 cells takes 280 kB, and 10,000 robots can have as many goals. If their
fields would take more than ``MAX_BYTES``, robots head for one of some cells that are spread over
the floor, the landmarks, and for their goal once no landmark is nearer to it.

Source: Goldberg and Harrelson (2005), Computing the shortest path: A* search meets graph theory,
SODA, for distances through landmarks.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from agents.mapf import graph as graphs
from agents.mapf.graph import Fields
from agents.mapf.kernels.places import FAR, NONE
from warehouse_core.world.tables import Integers

FIELDS_PER_LANDMARK = 4
"""Distance fields per landmark; most of them are for goals that robots are near."""

DETOUR_PRICE = 16
"""Price of a step of detour: a landmark has to be nearer to the goal by this many steps."""

UNKNOWN = FAR >> 1
"""Distance that stands for larger ones, so that the sum of two has 32 bits."""


class Waypoints:
    """The waypoints of robots, given the distance fields of their planner."""

    def __init__(self, fields: Fields, robots: int) -> None:
        self._fields, row = fields, fields.graph.places * fields.matrix.itemsize
        self._most = max(graphs.MAX_BYTES // row, FIELDS_PER_LANDMARK)
        self._side = int(np.ceil((FIELDS_PER_LANDMARK * fields.graph.size / self._most) ** 0.5))
        self._aims, self._goals = np.full((2, robots), NONE)
        self._open = fields.graph.layout.open_cells

    def toward(self, goals: Integers, cells: Integers) -> Integers:
        """Return the cells to which robots have to move first, ``[R]``.

        These are their goals, unless the fields of all goals take too much memory.
        """
        if len(goals) <= self._most or len(np.unique(goals)) <= self._most:
            return goals
        distances, aims, at = self._distances, self._aims, self._number[cells]
        aims[goals != self._goals] = NONE
        is_near = distances[at, aims] <= self._side // 2 * self._fields.step
        is_new = (goals != self._goals) | (is_near & (aims != NONE))
        room = self._most - len(self._landmarks) - int((~is_new & (aims == NONE)).sum())
        new, self._goals = np.flatnonzero(is_new), goals.copy()
        here, there = distances[at[new]], distances[self._number[goals[new]]]
        left = np.where(aims[new] == NONE, UNKNOWN, there[np.arange(len(new)), aims[new]])
        through = (here + there).astype(np.int64)
        is_last = through.min(axis=1) <= self._side * self._fields.step
        through[there >= left[:, None]] = UNKNOWN
        aims[new] = (DETOUR_PRICE * through + there).argmin(axis=1)
        is_last |= through.min(axis=1) >= UNKNOWN
        last = new[is_last]
        aims[last] = NONE
        # The goals of the others have no fields as long as too many robots are near theirs.
        late = last[goals[last] != cells[last]][max(room, 0) :]
        aims[late] = distances[self._number[goals[late]]].argmin(axis=1)
        return np.where(aims == NONE, goals, self._landmarks[aims])

    @cached_property
    def _landmarks(self) -> Integers:
        """The open cell nearest to the middle of each square block of the floor."""
        graph, side = self._fields.graph, self._side
        places = np.array(np.divmod(self._open, graph.layout.width))
        block = places[0] // side * graph.size + places[1] // side
        order = np.lexsort((np.abs(places % side - side // 2).sum(axis=0), block))
        result: Integers = self._open[order[np.unique(block[order], return_index=True)[1]]]
        return result

    @cached_property
    def _number(self) -> Integers:
        """Number of each open cell, ``[size]``."""
        result, cells = np.zeros(self._fields.graph.size, np.intp), self._open
        result[cells] = np.arange(len(cells))
        return result

    @cached_property
    def _distances(self) -> NDArray[np.int32]:
        """Distances between open cells and landmarks, ``[open cells, landmarks]``."""
        rows, size = self._fields.rows(self._landmarks), self._fields.graph.size
        result = np.empty((len(self._open), len(rows)), np.int32)
        for column, row in enumerate(rows):
            field = self._fields.matrix[row].reshape(-1, size)[:, self._open].min(axis=0)
            result[:, column] = np.minimum(field, UNKNOWN)
        return result
