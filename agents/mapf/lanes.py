"""Lanes, or highways: costs of moves that make robots avoid one another.

Moves against a lane are allowed but cost more, so that every reachable cell stays reachable. See
``traffic.py`` for lanes that are learned.

Source: Cohen, Uras and Koenig (2015), Feasibility study: using highways for bounded-suboptimal
multi-agent path finding, SoCS.
"""

from __future__ import annotations

import numpy as np

from agents.mapf.graph import Costs
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.layout import Layout

__all__ = ["lane_costs"]

WRONG_WAY = 5.0
"""Cost of a move against its lane."""


def lane_costs(layout: Layout, wrong_way: float = WRONG_WAY) -> Costs:
    """Return the costs of the moves N, E, S and W from each cell, ``[H * W, 4]``, for a ``Graph``.

    These moves are against a lane and cost ``wrong_way``: west in an even row, east in an odd row,
    north in an even column, and south in an odd column. All other moves cost 1.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lanes import lane_costs
        >>> from agents.mapf.pibt import PIBT
        >>> from warehouse_core import shelf_layout
        >>> layout = shelf_layout(aisle=2)
        >>> planner = PIBT(Graph(layout, lane_costs(layout)))
    """
    costs = np.ones((layout.height, layout.width, 4), np.float32)
    north, east, south, west = map(ACTIONS.index, "NESW")
    costs[0::2, :, west] = costs[1::2, :, east] = wrong_way
    costs[:, 0::2, north] = costs[:, 1::2, south] = wrong_way
    return costs.reshape(-1, 4)
