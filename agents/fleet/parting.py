"""Robots that share a cell, as bodies may after a disturbance, leave it one after the other."""

from __future__ import annotations

import numpy as np

from agents.mapf.graph import CLOSED, Graph
from agents.mapf.planner import Situation
from warehouse_core.world.tables import Integers


def part(graph: Graph, situation: Situation, chosen: Integers) -> Integers:
    """Return the next cells where of robots that share a cell the first leaves it, if it can.

    Bodies may come to rest over one cell after a disturbance. To the planner both stay.
    """
    cells = situation.cells
    first = np.unique(cells, return_index=True)[1]
    others = np.setdiff1d(np.arange(len(cells)), first)
    taken = {CLOSED, *cells.tolist(), *chosen.tolist(), *situation.closed.tolist()}
    parted = chosen.copy()
    for cell in np.unique(cells[others]).tolist():
        free = [side for side in graph.neighbours[cell].tolist() if side not in taken]
        if free:
            parted[np.argmax(cells == cell)] = free[0]
            taken.add(free[0])
    return parted
