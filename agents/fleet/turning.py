"""The actions of robots with headings, from where a planner wants them next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.fleet.parting import part
from agents.fleet.scheduler import shares_cell
from agents.mapf.graph import Graph
from agents.mapf.planner import Situation
from warehouse_core.world.actions import DROP, PICK, WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT, TURN_ACTIONS
from warehouse_core.world.tables import Integers

_WAITS = TURN_ACTIONS.index("WAIT")

_TURNS = np.array([_WAITS, RIGHT, RIGHT, LEFT])
"""Action that turns a robot, by the quarters to the right that it has to turn."""

_HANDLES = np.full(DROP + 1, _WAITS)
_HANDLES[[PICK, DROP]] = TURN_ACTIONS.index("PICK"), TURN_ACTIONS.index("DROP")
"""Index in ``TURN_ACTIONS`` of picks and drops, by their index in ``ACTIONS``."""


def turning_actions(
    graph: Graph, situation: Situation, headings: Integers, places: Integers, actions: Integers
) -> NDArray[np.intp]:
    """Return what robots do, ``[R]`` indices into ``TURN_ACTIONS``.

    Args:
        graph: floor.
        situation: situation before the step.
        headings: ``[R]`` headings before it.
        places: ``[R]`` places after it, see ``BasePlanner``.
        actions: ``[R]``, ``PICK`` or ``DROP``; or ``WAIT`` for robots that move, turn or wait.
    """
    cells = situation.cells
    wanted, to = np.divmod(places, graph.size)
    if shares_cell(cells).any():
        parted = part(graph, situation, to)
        away = (graph.neighbours[cells, :WAIT] == parted[:, None]).argmax(axis=1)
        wanted = np.where(parted != to, away, wanted)
        to = np.where((parted != to) & (away != headings), cells, parted)
    moves = np.where(to != cells, FORWARD, _TURNS[(wanted - headings) % len(_TURNS)])
    return np.where(actions == WAIT, moves, _HANDLES[actions])
