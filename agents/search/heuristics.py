"""Heuristics for routes and deliveries: estimates of the cost that is still to come.

Each is admissible, it never overestimates, and consistent, it never falls by more than an action
costs (section 3.5.2): so A* finds a path of least cost, and expands no state twice.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable

import numpy as np

from agents.search.algorithms import Heuristic
from agents.search.belief import BeliefProblem
from agents.search.problems import DELIVERED, DeliveryProblem, RouteProblem, State
from warehouse_core.world.distances import Distances, distances
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell


def zero(state: Hashable) -> float:
    """Estimate nothing: with it A* is uniform-cost search."""
    return 0.0


def manhattan(problem: RouteProblem | BeliefProblem) -> Heuristic[Cell]:
    """Return the steps to the goal as if there were no walls."""
    goal_row, goal_col = problem.goal

    def estimate(cell: Cell) -> float:
        return abs(cell[0] - goal_row) + abs(cell[1] - goal_col)

    return estimate


def true_distance(problem: RouteProblem, layout: Layout) -> Heuristic[Cell]:
    """Return the steps to the goal round the walls: A* then expands nothing in vain."""
    table = distances(layout, [problem.goal]).tolist()
    return lambda cell: float(table[cell[0]][cell[1]])


def manhattan_delivery(problem: DeliveryProblem) -> Heuristic[State]:
    """Return the cost of the delivery as if there were no walls."""
    empty, loaded, pick, drop = problem.costs
    ends = list(problem.dropoffs)
    if not ends:
        return lambda state: 0.0 if state == DELIVERED else np.inf
    # From each pickup on, the way is the same wherever the robot comes from.
    begun = [(cell, pick + loaded * _nearest(cell, ends) + drop) for cell in problem.pickups]

    def estimate(state: State) -> float:
        row, col, has_item = state
        if state == DELIVERED:
            return 0.0
        if has_item:
            return loaded * _nearest((row, col), ends) + drop
        return min(
            (empty * (abs(row - r) + abs(col - c)) + rest for (r, c), rest in begun),
            default=np.inf,
        )

    return estimate


def true_delivery(problem: DeliveryProblem) -> Heuristic[State]:
    """Return the cost of the delivery round the walls."""
    empty, loaded, pick, drop = problem.costs
    with_item = _priced(loaded, distances(problem.layout, problem.dropoffs)) + drop
    without = np.full_like(with_item, np.inf)
    for cell in problem.pickups:
        way = _priced(empty, distances(problem.layout, [cell])) + pick + with_item[cell]
        np.minimum(without, way, out=without)
    tables = without.tolist(), with_item.tolist()

    def estimate(state: State) -> float:
        row, col, has_item = state
        return 0.0 if state == DELIVERED else float(tables[has_item][row][col])

    return estimate


def _nearest(cell: Cell, cells: Collection[Cell]) -> float:
    row, col = cell
    return min(abs(row - r) + abs(col - c) for r, c in cells)


def _priced(price: float, steps: Distances) -> Distances:
    """Return what steps cost; where no way leads, not even free steps do."""
    return np.multiply(price, steps, out=np.full_like(steps, np.inf), where=np.isfinite(steps))
