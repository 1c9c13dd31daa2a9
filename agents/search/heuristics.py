"""Heuristics for routes and deliveries: estimates of the cost to the goal.

Each is admissible, it never overestimates, and consistent, it never decreases by more than the cost
of an action (section 3.5.2). So A* finds a path of least cost and expands no state twice.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable

from agents.search.algorithms import Heuristic
from agents.search.belief import BeliefProblem
from agents.search.problems import DELIVERED, DeliveryProblem, RouteProblem, State
from warehouse_core.world.distances import distances
from warehouse_core.world.layout import Layout
from warehouse_core.world.tiles import Cell


def zero(state: Hashable) -> float:
    """Return 0; with this heuristic A* is uniform-cost search."""
    return 0.0


def manhattan(problem: RouteProblem | BeliefProblem) -> Heuristic[Cell]:
    """Return the heuristic of the steps to the goal without walls."""
    goal_row, goal_col = problem.goal

    def estimate(cell: Cell) -> float:
        return abs(cell[0] - goal_row) + abs(cell[1] - goal_col)

    return estimate


def true_distance(problem: RouteProblem, layout: Layout) -> Heuristic[Cell]:
    """Return the exact steps to the goal as a heuristic; A* then expands only the path."""
    table = distances(layout, [problem.goal]).tolist()
    return lambda cell: float(table[cell[0]][cell[1]])


def manhattan_delivery(problem: DeliveryProblem) -> Heuristic[State]:
    """Return the heuristic of the cost of the delivery without walls."""
    empty, loaded, pick, drop = problem.costs
    ends = list(problem.dropoffs)
    if not ends:
        return lambda state: 0.0 if state == DELIVERED else math.inf
    # The rest of the delivery from each pickup is the same for every state.
    begun = [(cell, pick + loaded * _nearest(cell, ends) + drop) for cell in problem.pickups]

    def estimate(state: State) -> float:
        row, col, has_item = state
        if state == DELIVERED:
            return 0.0
        if has_item:
            return loaded * _nearest((row, col), ends) + drop
        return min(
            (empty * (abs(row - r) + abs(col - c)) + rest for (r, c), rest in begun),
            default=math.inf,
        )

    return estimate


def _nearest(cell: Cell, cells: Collection[Cell]) -> float:
    row, col = cell
    return min(abs(row - r) + abs(col - c) for r, c in cells)
