"""Lanes: costs of moves that keep robots out of one another's way.

A move against its lane is allowed but costs more, so every cell that could be reached still can be.
See ``traffic.py`` for lanes that are learned.

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

    Moves cost ``wrong_way`` west in an even row, east in an odd one, north in an even column, south
    in an odd one; other moves cost 1.

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
