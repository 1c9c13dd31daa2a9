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
from warehouse_core.world.tables import Integers

__all__ = ["aisle_costs", "lane_costs"]

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
    return _lane_costs(layout, np.arange(layout.height), np.arange(layout.width), wrong_way)


def aisle_costs(layout: Layout, wrong_way: float = WRONG_WAY) -> Costs:
    """Return the costs of moves with lanes in aisles only, ``[H * W, 4]``, as ``lane_costs``.

    Aisles are the rows that have at least as many open cells as a row has in the mean, and such
    columns. Of two aisles that follow one another, one runs east or south, the other west or north,
    however many rows or columns of shelves are between them.

    Example:
        >>> from agents.mapf.lanes import aisle_costs
        >>> from warehouse_core import Layout
        >>> costs = aisle_costs(Layout([".....", ".###.", "....."]), wrong_way=3)
        >>> costs[2].tolist(), costs[12].tolist()
        ([1.0, 1.0, 1.0, 3.0], [1.0, 3.0, 1.0, 1.0])
    """
    is_open = np.zeros((layout.height, layout.width), np.bool_)
    is_open.flat[layout.open_cells] = True
    counts = is_open.sum(axis=1), is_open.sum(axis=0)
    rows, columns = (np.flatnonzero(count >= count.mean()) for count in counts)
    return _lane_costs(layout, rows, columns, wrong_way)


def _lane_costs(layout: Layout, rows: Integers, columns: Integers, wrong_way: float) -> Costs:
    """Return the costs of moves with lanes in some rows and columns."""
    costs = np.ones((layout.height, layout.width, 4), np.float32)
    north, east, south, west = map(ACTIONS.index, "NESW")
    costs[rows[0::2], :, west] = costs[rows[1::2], :, east] = wrong_way
    costs[:, columns[0::2], north] = costs[:, columns[1::2], south] = wrong_way
    return costs.reshape(-1, 4)
