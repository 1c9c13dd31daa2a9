"""Task assignment: the choice of a robot for each order.

Each function takes ``Tasks`` of ``N`` robots and ``K`` orders and returns ``[N]`` intp: the column
of the order of each robot, or ``NONE``. No order is assigned to two robots, and no robot gets an
order that it cannot reach.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.mapf.kernels.places import NONE
from warehouse_core.world.tables import Integers

OUT_OF_REACH = 1e9
"""Finite stand-in for an infinite cost, which ``linear_sum_assignment`` does not accept."""

STRETCH = 1.15
"""Ratio of the expected steps of a robot in traffic to the steps of its shortest path."""

HANDLING = 2
"""Steps for picking and dropping."""

URGENT, LATE = 30.0, 15.0
"""Detour in steps that an order without spare time is worth, and detour that a late order costs."""

KEEP = 3.0
"""Steps by which another order must be better before a robot gives up its current one.

Without this margin, robots would switch orders at every tie.
"""

SPARE = 40.0
"""Spare time in steps at which the urgency of an order has decayed to ``exp(-1)`` of ``URGENT``."""


class Tasks(NamedTuple):
    """Robots that wait for an order and orders that wait for a robot.

    Attributes:
        times: ``[N, K]``, the travel time of each robot to the pickup of each order. It is infinite
            if the robot cannot or must not take the order. The unit is the time for one cell at top
            speed, which is one step on the grid.
        trips: ``[K]``, the times from pickup to dropoff.
        due: ``[K]``, the deadline of each order. Orders are sorted by release.
        now: present time.
        held: ``[N]``, the order that each robot is already on its way to, or ``NONE``.
    """

    times: NDArray[np.floating]
    trips: NDArray[np.floating]
    due: NDArray[np.floating]
    now: float
    held: Integers


Assignment = Callable[[Tasks], NDArray[np.intp]]


def first_in_first_out(tasks: Tasks) -> NDArray[np.intp]:
    """Assign the orders from the oldest on, each to the nearest robot that has none."""
    times = np.array(tasks.times, np.float64)
    assigned = np.full(len(times), NONE)
    for order in range(times.shape[1]):
        if not (assigned == NONE).any():
            break
        robot = int(times[:, order].argmin())
        if np.isfinite(times[robot, order]):
            assigned[robot], times[robot] = order, np.inf
    return assigned


def nearest_first(tasks: Tasks) -> NDArray[np.intp]:
    """Assign the nearest pair of robot and order, then repeat with the rest.

    Pairs that are nearest to each other are assigned at the same time, with the same result.
    """
    times = np.array(tasks.times, np.float64)
    assigned = np.full(len(times), NONE)
    while np.isfinite(times).any():
        order_of, robot_of = times.argmin(axis=1), times.argmin(axis=0)
        robots = np.flatnonzero(robot_of[order_of] == np.arange(len(times)))
        robots = robots[np.isfinite(times[robots, order_of[robots]])]
        assigned[robots] = order_of[robots]
        times[robots], times[:, assigned[robots]] = np.inf, np.inf
    return assigned


def hungarian(tasks: Tasks) -> NDArray[np.intp]:
    """Assign as many orders as possible with the smallest sum of travel times.

    Source: Kuhn (1955), The Hungarian method for the assignment problem. SciPy's solver follows
    Crouse (2016), On implementing 2D rectangular assignment algorithms.
    """
    return _cheapest(tasks, tasks.times)


def urgent(tasks: Tasks) -> NDArray[np.intp]:
    """Assign orders as ``hungarian`` does, but let orders that are soon due seem nearer.

    The less spare time an order has, the nearer it seems, by up to ``URGENT`` steps. An order that
    a robot can no longer deliver in time seems ``LATE`` steps farther away.
    """
    needed = STRETCH * (tasks.times + tasks.trips) + HANDLING
    spare = tasks.due - tasks.now - needed
    # Versions of NumPy differ in the last bit of an exponential, which could decide a tie.
    near = np.round(np.exp(-np.maximum(spare, 0) / SPARE), 6)
    worth = np.where(spare < 0, -LATE, URGENT * near)
    return _cheapest(tasks, tasks.times - worth)


def _cheapest(tasks: Tasks, costs: NDArray[np.floating]) -> NDArray[np.intp]:
    assigned = np.full(len(costs), NONE)
    reachable = np.isfinite(costs)
    costs = np.where(reachable, costs, OUT_OF_REACH)
    held = np.flatnonzero(tasks.held != NONE)
    costs[held, tasks.held[held]] -= KEEP
    robots, orders = cheapest_matching(costs)
    given = reachable[robots, orders]
    assigned[robots[given]] = orders[given]
    return assigned


def cheapest_matching(costs: NDArray[np.floating]) -> tuple[Integers, Integers]:
    """Return the rows and the columns of a matching with the least sum of costs.

    The matching has as many pairs as there are rows or columns, whichever are fewer, and its rows
    ascend. If SciPy is not installed, as in a browser, the same algorithm in Python finds the same
    matching, ties included.

    Args:
        costs: ``[N, M]`` finite costs.
    """
    try:
        from scipy.optimize import linear_sum_assignment
    except ImportError:
        if len(costs) <= costs.shape[1]:
            return np.arange(len(costs)), _match(costs)
        rows = _match(costs.T)
        order = np.argsort(rows)
        return rows[order], order
    rows, columns = linear_sum_assignment(costs)
    return rows, columns


def _match(costs: NDArray[np.floating]) -> Integers:
    """Return the column of each row, ``[N]``, for at most as many rows as columns.

    Each row in turn takes a column along a cheapest augmenting path.

    Source: Crouse (2016), On implementing 2D rectangular assignment algorithms, IEEE Transactions
    on Aerospace and Electronic Systems 52 (4).
    """
    rows, columns = costs.shape
    row_price, column_price = np.zeros(rows), np.zeros(columns)
    row_of, column_of = np.full(columns, NONE), np.full(rows, NONE)
    for start in range(rows):
        shortest, path = np.full(columns, np.inf), np.full(columns, NONE)
        remaining = np.arange(columns)[::-1].copy()
        row, lowest, seen = start, 0.0, [start]
        while True:
            reached = lowest + costs[row, remaining] - row_price[row] - column_price[remaining]
            is_shorter = reached < shortest[remaining]
            shortest[remaining[is_shorter]] = reached[is_shorter]
            path[remaining[is_shorter]] = row
            lowest = shortest[remaining].min()
            nearest = np.flatnonzero(shortest[remaining] == lowest)
            free = nearest[row_of[remaining[nearest]] == NONE]
            # Among equally near columns, take the last one that is free, else the first one.
            index = free[-1] if len(free) else nearest[0]
            column, remaining[index] = remaining[index], remaining[-1]
            remaining = remaining[:-1]
            if row_of[column] == NONE:
                break
            row = row_of[column]
            seen.append(row)
        others = seen[1:]
        row_price[start] += lowest
        row_price[others] += lowest - shortest[column_of[others]]
        scanned = np.setdiff1d(np.arange(columns), remaining)
        column_price[scanned] -= lowest - shortest[scanned]
        while column != NONE:
            row = path[column]
            row_of[column] = row
            column, column_of[row] = column_of[row], column
    return column_of


ASSIGNMENTS: dict[str, Assignment] = {
    "fifo": first_in_first_out,
    "nearest": nearest_first,
    "hungarian": hungarian,
    "urgent": urgent,
}
"""Assignments by name."""

REASSIGNING = ("hungarian", "urgent")
"""Assignments that may move an order to another robot until its item is picked."""
