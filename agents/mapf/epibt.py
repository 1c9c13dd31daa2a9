"""Rounds of EPIBT, in which robots with headings choose several actions at once.

See ``kernels/epibt.py``.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from agents.mapf.graph import CLOSED, Fields, Graph
from agents.mapf.kernels.epibt import Epibt, epibt_of
from agents.mapf.kernels.places import NONE, STAY
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers

OPERATION_STEPS = 3
"""Steps for which robots choose their actions in a round."""


def epibt_on(fields: Fields, robots: int) -> Epibt:
    """Return the buffers of EPIBT for robots with headings on a floor."""
    beside = fields.graph.neighbours[:, :WAIT]
    ahead = np.where(beside == CLOSED, NONE, beside)
    return epibt_of(ahead, turning_operations(OPERATION_STEPS), robots)


def outward_cells(graph: Graph) -> Integers:
    """Return for each cell in a dead end the next on the way out of it, else ``NONE``, ``[size]``.

    A dead end is what is left of a tree of cells, beyond the first cell that has another way.
    """
    beside = graph.neighbours[:, :WAIT]
    degree, outward = (beside != CLOSED).sum(axis=1), np.full(graph.size, NONE)
    ends = np.flatnonzero(degree == 1).tolist()
    while ends:
        cell = ends.pop()
        for out in beside[cell].tolist():
            if degree[cell] == 1 and out != CLOSED and outward[out] == NONE:
                outward[cell], degree[cell] = out, 0
                degree[out] -= 1
                if degree[out] == 1:
                    ends.append(out)
    return outward


def turning_operations(window: int) -> Integers:
    """Return sequences of moves, turns and waits through a window, the one of waits first.

    The actions are ``FORWARD``, ``RIGHT``, ``LEFT`` and ``STAY``. Of several sequences that lead
    through the same cells to the same heading, the one with the fewest turns is left, and of these
    the one that turns first.
    """
    found: dict[tuple[object, ...], tuple[int, ...]] = {}
    every = product((FORWARD, RIGHT, LEFT, STAY), repeat=window)
    for actions in sorted(every, key=lambda each: (each.count(RIGHT) + each.count(LEFT), each)):
        place, heading, way = 0j, 1 + 0j, list[object]()
        for action in actions:
            heading *= {RIGHT: 1j, LEFT: -1j}.get(action, 1)
            place += heading * (action == FORWARD)
            way.append(place)
        found.setdefault((*way, heading), actions)
    return np.array(sorted(found.values(), key=lambda each: each != (STAY,) * window))
