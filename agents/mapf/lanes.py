"""Costs of moves that keep robots out of one another's way: lanes, and lanes learned from traffic.

A move against its lane is allowed but costs more, so every cell that could be reached still can be.

Sources: Cohen, Uras and Koenig (2015), Feasibility study: using highways for bounded-suboptimal
multi-agent path finding, SoCS. Zhang, Jiang, Bhatt, Nikolaidis and Li (2024), Guidance graph
optimization for lifelong multi-agent path finding, IJCAI. Chen, Harabor, Li and Stuckey (2024),
Traffic flow optimisation for lifelong multi-agent path finding, AAAI.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from agents.mapf.graph import CLOSED, Costs, Graph
from agents.mapf.lifelong import run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core.world.actions import ACTIONS, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

__all__ = ["aisle_costs", "lane_costs", "learned_costs"]

WRONG_WAY = 5.0
"""Cost of a move against its lane."""

FIRST_WRONG_WAY = 1.5
"""Cost of a move against its lane in the first trial of learned costs."""

MOVE_COST, OPPOSED_COST, WAIT_COST = 2.0, 10.0, 2.0
"""Costs that traffic adds to a move, per step and occurrence: the same move, the opposite move, a
robot that waits in the cell to which it leads. Robots that meet head-on lose most.
"""

MIN_SHARE = 0.15
"""Smallest weight of the last trial in the mean traffic, so that late trials still count."""


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


def learned_costs(
    layout: Layout,
    robots: int,
    trials: int = 16,
    steps: int = 256,
    seed: int = 0,
    starts: Integers | None = None,
    goals: Integers | None = None,
) -> Costs:
    """Return costs of moves that were learned from the traffic of trial runs, as ``lane_costs``.

    In each trial PIBT leads robots by the costs so far, beginning with faint lanes. The
    costs then follow from the mean traffic of the trials: most where robots would meet head-on.
    The first trial has the seed, and the next trials have the next seeds; see ``run_lifelong`` for
    the other arguments and for errors.

    Example:
        >>> from agents.mapf.lanes import learned_costs
        >>> from warehouse_core import shelf_layout
        >>> learned_costs(shelf_layout(aisle=2), robots=8, trials=2, steps=20).shape
        (220, 4)
    """
    learned = Traffic(layout)
    for trial in range(trials):
        graph = Graph(layout, learned.costs)
        run = run_lifelong(
            graph, PIBT(graph, seed + trial), robots, steps, seed + trial, starts, goals
        )
        learned.add(run.cells)
    return learned.costs


class Traffic:
    """Costs of moves that follow from the mean traffic of trials, at first faint lanes.

    Attributes:
        costs: ``[H * W, 4]``, see ``lane_costs``.
    """

    def __init__(self, layout: Layout) -> None:
        self._graph, self._trials = Graph(layout), 0
        self.costs = self._lanes = lane_costs(layout, FIRST_WRONG_WAY)
        self._mean = np.zeros((self._graph.size, WAIT + 1))

    def add(self, cells: Integers) -> None:
        """Take over the cells of robots before each step of a trial and after the last."""
        self._trials += 1
        share = max(1 / self._trials, MIN_SHARE)
        self._mean += (traffic(self._graph, cells) - self._mean) * share
        costs = self._lanes + _traffic_costs(self._graph, self._mean)
        self.costs = np.round(costs, 1).astype(np.float32)


def traffic(graph: Graph, cells: Integers) -> NDArray[np.float64]:
    """Return how often in a step each move was made, and waiting, ``[H * W, 5]``.

    ``cells`` has the cells of the robots before each step and after the last, ``[T + 1, R]``.
    """
    before, after = cells[:-1].ravel(), cells[1:].ravel()
    moves = (graph.neighbours[before] == after[:, None]).argmax(1)
    made = (before * (WAIT + 1) + moves).astype(np.intp)  # 32 bits in a browser
    counts = np.bincount(made, minlength=graph.size * (WAIT + 1))
    return counts.reshape(-1, WAIT + 1) / (len(cells) - 1)


def _traffic_costs(graph: Graph, mean: NDArray[np.float64]) -> NDArray[np.float64]:
    reached = graph.neighbours[:, :WAIT]
    opposite = np.roll(np.arange(WAIT), 2)
    there = MOVE_COST * mean[:, :WAIT]
    back = OPPOSED_COST * mean[reached, opposite] + WAIT_COST * mean[reached, WAIT]
    return there + np.where(reached == CLOSED, 0, back)
