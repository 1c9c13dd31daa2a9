"""The planner of a fleet that ``warehouse train clone`` trains; running it needs only NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.fleet.charging import costs_around_chargers
from agents.fleet.guided import on_lanes
from agents.learning.traffic_network import TrafficNetwork
from agents.learning.traffic_view import IS_OPEN, Traffic, TrafficView
from agents.mapf.graph import Graph
from agents.mapf.kernels.buffers import buffer_of
from agents.mapf.pibt import PIBT
from agents.mapf.planner import Situation
from warehouse_core import Layout
from warehouse_core.arguments import instance_of
from warehouse_core.world.tables import Integers


class ClonePlanner(PIBT):
    """A planner by PIBT in which a network ranks the moves of each robot.

    The further the best move of a robot leads, the earlier the robot chooses; urgent robots are
    first. PIBT keeps the robots from colliding: a robot that is pushed away, or finds a cell taken,
    makes the move that the network ranks next. It also lets two swap that meet where neither can
    pass.

    Args:
        network: network that ranks the moves.
        graph: floor, with the costs of lanes if the network was trained with them.
        seed: seed of the order of robots that have been under way equally long.

    Attributes:
        views: views of the robots in the last step, ``[R, 5, SIZE]``.

    Raises:
        TypeError: it is no network, or no graph.

    Example:
        >>> import numpy as np
        >>> from agents.learning.clone_planner import ClonePlanner
        >>> from agents.learning.traffic_network import TrafficNetwork
        >>> from agents.learning.traffic_view import SIZE
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.lifelong import run_lifelong
        >>> from warehouse_core import random_layout
        >>> widths = [SIZE, 8, 8, 1]
        >>> layers = [(np.zeros((b, a)), np.zeros(b)) for a, b in zip(widths, widths[1:])]
        >>> network, graph = TrafficNetwork(False, layers), Graph(random_layout(9, 9, 0.2, 1))
        >>> run_lifelong(graph, ClonePlanner(network, graph), robots=4, steps=50, seed=1).reached
        0
    """

    ranks_moves = True

    def __init__(self, network: TrafficNetwork, graph: Graph, seed: int = 0) -> None:
        self._network = instance_of("network", network, TrafficNetwork)
        super().__init__(graph, seed)

    @classmethod
    def load(cls, path: Path, layout: Layout, seed: int = 0) -> ClonePlanner:
        """Return a planner for a layout, with a network from a file.

        Raises:
            RecordError: the file is not one of such a network.
            OSError: the file cannot be read.
        """
        return cls.on(TrafficNetwork.load(path), layout, seed)

    @classmethod
    def on(cls, network: TrafficNetwork, layout: Layout, seed: int = 0) -> ClonePlanner:
        """Return a planner for a layout, with lanes if the network was trained with them."""
        plain = Graph(layout, costs_around_chargers(layout))
        return cls(network, on_lanes(layout) if network.lanes else plain, seed)

    def reset(self) -> None:
        """Forget the last episode."""
        super().reset()
        self._view = TrafficView(self.fields)

    def next_cells(self, situation: Situation) -> Integers:
        """Return the cell of each robot after the next joint step; see ``Planner``."""
        self._urgent = situation.urgent
        return super().next_cells(situation)

    def _keys(
        self, rows: Integers, places: Integers, goals: Integers, robot_in: Integers
    ) -> NDArray[Any]:
        order = np.array(self._team.order)
        self.views = self._view.look(Traffic(places, goals, rows, order))
        is_open = self.views[:, :, IS_OPEN] > 0
        keys = np.where(is_open, -self._network.scores(self.views), np.inf)
        best, second = np.partition(keys, 1, axis=1)[:, :2].T
        leads = second - best
        leads[self._urgent] = np.inf
        self._team.order[:] = buffer_of(order[np.argsort(-leads[order], kind="stable")])
        return keys
