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
from agents.mapf.lifelong import LifelongRun, run_lifelong
from agents.mapf.pibt import PIBT
from warehouse_core.world.actions import ACTIONS, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers

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
    """
    costs = np.ones((layout.height, layout.width, 4), np.float32)
    north, east, south, west = map(ACTIONS.index, "NESW")
    costs[0::2, :, west] = costs[1::2, :, east] = wrong_way
    costs[:, 0::2, north] = costs[:, 1::2, south] = wrong_way
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
    """
    costs = lanes = lane_costs(layout, FIRST_WRONG_WAY)
    mean = np.zeros((len(lanes), WAIT + 1))
    for trial in range(trials):
        graph = Graph(layout, costs)
        run = run_lifelong(
            graph, PIBT(graph, seed + trial), robots, steps, seed + trial, starts, goals
        )
        mean += (traffic(graph, run) - mean) * max(1 / (trial + 1), MIN_SHARE)
        costs = np.round(lanes + _traffic_costs(graph, mean), 1).astype(np.float32)
    return costs


def traffic(graph: Graph, run: LifelongRun) -> NDArray[np.float64]:
    """Return how often in a step each move was made, and waiting, ``[H * W, 5]``."""
    before, after = run.cells[:-1].ravel(), run.cells[1:].ravel()
    moves = (graph.neighbours[before] == after[:, None]).argmax(1)
    counts = np.bincount(before * (WAIT + 1) + moves, minlength=graph.size * (WAIT + 1))
    return counts.reshape(-1, WAIT + 1) / len(run.seconds)


def _traffic_costs(graph: Graph, mean: NDArray[np.float64]) -> NDArray[np.float64]:
    reached = graph.neighbours[:, :WAIT]
    opposite = np.roll(np.arange(WAIT), 2)
    there = MOVE_COST * mean[:, :WAIT]
    back = OPPOSED_COST * mean[reached, opposite] + WAIT_COST * mean[reached, WAIT]
    return there + np.where(reached == CLOSED, 0, back)
