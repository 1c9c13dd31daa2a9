"""Distance fields of robots with headings, which drive forward and turn on the spot."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from agents.mapf.graph import CLOSED, Fields, Graph
from agents.mapf.kernels.floor import ACTIONS, STAY
from warehouse_core.world.actions import WAIT
from warehouse_core.world.moves import FORWARD, LEFT, RIGHT
from warehouse_core.world.tables import Integers


class HeadedFields(Fields):
    """Distances between places of which each move and each quarter turn is a step.

    The actions of ``near`` and ``prices`` are ``FORWARD``, ``RIGHT``, ``LEFT``, one that leads
    nowhere, and waiting.

    Args:
        graph: floor; turns take a step each, whatever its ``turn_cost`` is.
    """

    def __init__(self, graph: Graph) -> None:
        super().__init__(graph.with_costs(graph.costs, 1.0))
        self._leads_back = True
        if graph.costs is None:
            self.step = 1

    @cached_property
    def near(self) -> Integers:
        """Place that each action leads to from each place, ``[places, 5]``, or ``places``."""
        graph, places = self._rounded, np.arange(self._rounded.places).reshape(WAIT, -1)
        found = np.full((*places.shape, ACTIONS), graph.places)
        ahead = graph.neighbours[:, :WAIT].T
        is_shut = (ahead == CLOSED) | np.isin(ahead, list(graph.closed))
        found[..., FORWARD] = np.where(is_shut, graph.places, ahead + places[:, :1])
        found[..., RIGHT], found[..., LEFT] = (
            np.roll(places, -1, axis=0),
            np.roll(places, 1, axis=0),
        )
        found[..., STAY] = places
        return found.reshape(-1, ACTIONS)

    @cached_property
    def prices(self) -> Integers:
        """Costs of the steps of ``near``, ``[places, 5]``."""
        graph = self._rounded
        found = np.full((WAIT, graph.size, ACTIONS), self.step)
        if graph.costs is not None:
            found[..., FORWARD] = np.rint(graph.costs.T * self.step)
        return found.reshape(-1, ACTIONS)
