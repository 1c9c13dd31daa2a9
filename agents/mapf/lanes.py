"""Lanes: costs that make neighbouring rows run east and west, and columns north and south, in turn.

A move against its lane is allowed but costs more, so every cell that could be reached still can be.

Source: Cohen, Uras and Koenig (2015), Feasibility study: using highways for bounded-suboptimal
multi-agent path finding, SoCS.
"""

from __future__ import annotations

import numpy as np

from agents.mapf.graph import Costs
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.layout import Layout

WRONG_WAY = 5.0


def lane_costs(layout: Layout, wrong_way: float = WRONG_WAY) -> Costs:
    """Return the costs of the moves N, E, S and W from each cell, ``[H * W, 4]``, for a ``Graph``.

    Args:
        layout: any.
        wrong_way: the cost of a move west in an even row, east in an odd one, north in an even
            column, south in an odd one; other moves cost 1.
    """
    costs = np.ones((layout.height, layout.width, 4), np.float32)
    north, east, south, west = map(ACTIONS.index, "NESW")
    costs[0::2, :, west] = costs[1::2, :, east] = wrong_way
    costs[:, 0::2, north] = costs[:, 1::2, south] = wrong_way
    return costs.reshape(-1, 4)
