"""Travel times of robots on a floor, which do not depend on a planner's costs of moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import Fields, Graph
from agents.mapf.kernels.places import FAR
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers


class TravelTimes:
    """Times of the shortest paths between cells; a cell at top speed takes 1.

    Orders, chargers and batteries are planned with these times. The costs of a planner's graph,
    such as 5 for a move against a lane, are not times, so no graph can be passed. On one floor, a
    charger 14 steps away used to count as 56 away, and the fleet delivered 40 items, not 102.

    Args:
        layout: floor.
        turn: time of a quarter turn.
    """

    def __init__(self, layout: Layout, turn: float = 0.0) -> None:
        self._fields = Fields(Graph(layout, turn_cost=turn))

    def close(self, cells: frozenset[int]) -> None:
        """Close these cells to all paths, and reopen the cells that were closed before."""
        self._fields.graph.close(cells)

    def between(self, cells: Integers, goals: Integers) -> NDArray[np.float64]:
        """Return the times from cells to goals, which are broadcast; infinite without a path.

        The robots start in the best direction.
        """
        fields, graph = self._fields, self._fields.graph
        rows, headings = fields.rows(goals), np.arange(0, graph.places, graph.size)
        times = fields.matrix[rows[..., None], cells[..., None] + headings].min(axis=-1)
        return np.where(times == FAR, np.inf, times / fields.step)
