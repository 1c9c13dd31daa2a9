"""Heuristics for routes and deliveries: estimates of the cost to the goal.

Each heuristic is admissible: it never overestimates. Each is also consistent: an action never
reduces it by more than the cost of the action (section 3.5.2). A* therefore finds a path of least
cost and expands no state twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray

from agents.search.algorithms import Heuristic
from agents.search.belief import BeliefProblem
from agents.search.problems import DELIVERED, DeliveryProblem, DeliveryState, RouteProblem
from warehouse_core.arguments import instance_of
from warehouse_core.world.distances import distances
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell

CostTable = NDArray[np.float64]
"""``[H, W]`` cost of each cell, infinite without a path."""

MAX_COMPARED = 16
"""Most stations of a kind that are compared for each state. For more stations, a table of the costs
of all cells is computed once."""


def zero(state: Hashable) -> float:
    """Return 0. With this heuristic, A* is uniform-cost search."""
    return 0.0


def manhattan(problem: RouteProblem | BeliefProblem) -> Heuristic[Cell]:
    """Return the Manhattan distance to the goal as a heuristic, which ignores walls.

    Example:
        >>> from agents.search import RouteProblem, manhattan
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> estimate = manhattan(RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10)))
        >>> estimate((1, 1))
        13
    """
    goal_row, goal_col = problem.goal

    def estimate(cell: Cell) -> float:
        row, col = cell
        return abs(row - goal_row) + abs(col - goal_col)

    return estimate


def true_distance(problem: RouteProblem, layout: Layout) -> Heuristic[Cell]:
    """Return the exact number of steps to the goal as a heuristic. A* then expands only the path.

    Example:
        >>> from agents.search import RouteProblem, true_distance
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> estimate = true_distance(RouteProblem(DEFAULT_LAYOUT, (1, 1), (5, 10)), DEFAULT_LAYOUT)
        >>> estimate((1, 1))
        13.0
    """
    instance_of("layout", layout, Layout)
    table = distances(layout, [problem.goal]).tolist()
    return lambda cell: float(table[cell[0]][cell[1]])


def manhattan_delivery(problem: DeliveryProblem) -> Heuristic[DeliveryState]:
    """Return the least cost of a delivery without walls as a heuristic.

    Example:
        >>> from agents.search import DeliveryProblem, manhattan_delivery
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> problem = DeliveryProblem(DEFAULT_LAYOUT, (1, 1))
        >>> manhattan_delivery(problem)(problem.initial)
        11.0
    """
    empty, loaded, pick, drop = problem.costs
    with_item = _least_cost(dict.fromkeys(problem.dropoffs, drop), loaded, problem.size)
    begun = {cell: pick + with_item(*cell) for cell in problem.pickups}
    without_item = _least_cost(begun, empty, problem.size)

    def estimate(state: DeliveryState) -> float:
        row, col, has_item = state
        if state == DELIVERED:
            return 0.0
        return with_item(row, col) if has_item else without_item(row, col)

    return estimate


def _least_cost(
    stations: dict[Cell, float], move: float, size: tuple[int, int]
) -> Callable[[int, int], float]:
    """Return a function from a row and a column to the least cost of a path through a station.

    ``stations`` has the remaining cost at each station, and ``move`` is the cost of a move.
    """
    if len(stations) > MAX_COMPARED:
        # Otherwise the search would compare all stations at each of its nodes.
        table = np.full(size, np.inf)
        table[tuple(np.transpose([*stations]))] = [*stations.values()]
        return _spread(table, move).item

    def least(row: int, col: int) -> float:
        return min(
            [move * (abs(row - r) + abs(col - c)) + cost for (r, c), cost in ends],
            default=math.inf,
        )

    ends = [*stations.items()]
    return least


def _spread(costs: CostTable, move: float) -> CostTable:
    """Return for each cell the least sum of the cost at any cell and the cost of the moves to it.

    The two axes are processed one after the other, each in both directions, so the run time is
    linear in the number of cells.

    Source: Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions, Theory of
    Computing 8 (2012): the transform under the L1 norm.
    """
    for _ in range(2):
        costs = costs.T
        ramp = move * np.arange(costs.shape[1])
        ahead = np.minimum.accumulate(costs - ramp, axis=1) + ramp
        back = np.minimum.accumulate((costs + ramp)[:, ::-1], axis=1)[:, ::-1] - ramp
        costs = np.minimum(ahead, back)
    return costs
