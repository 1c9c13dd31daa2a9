"""Headings and ages of robots, which a planner remembers from one joint step to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import EAST, Graph
from agents.mapf.kernels.places import NONE
from warehouse_core.world.tables import Integers


class Memory:
    """The headings and ages of ``R`` robots; an age is the number of steps since the last goal.

    Args:
        graph: floor.
        ranks: ``[R]`` different numbers from 0 to 1, which order robots of equal age.

    Attributes:
        goals: ``[R]``, the goals in the previous step.
        ages: ``[R]``, the ages of the robots in that step.
    """

    def __init__(self, graph: Graph, ranks: NDArray[np.float64]) -> None:
        self._graph, self._ranks, robots = graph, ranks, len(ranks)
        self.goals, self.ages = np.full(robots, NONE), np.zeros(robots, np.intp)
        self._cells, self._headings = np.full(robots, NONE), np.full(robots, EAST)

    def places(self, cells: Integers) -> Integers:
        """Return the places of the robots, which face where they last moved, and east at first."""
        if not self._graph.turn_cost:
            return cells
        before = np.where(self._cells == NONE, cells, self._cells)
        self._headings = self._graph.headings(before, cells, self._headings)
        self._cells = cells.copy()
        return self._headings * self._graph.size + cells

    def order(self, cells: Integers, goals: Integers, urgent: Integers) -> Integers:
        """Return the robots by decreasing priority: urgent robots first, then the oldest."""
        is_there = (cells == goals) | (cells == self.goals)
        self.ages, self.goals = np.where(is_there, 0, self.ages + 1), goals.copy()
        priorities = self.ages + self._ranks
        priorities[urgent] += self.ages.max(initial=0) + 1
        return np.argsort(-priorities, kind="stable")
