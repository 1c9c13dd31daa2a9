"""Task assignment: which robot goes for which order.

Each function takes ``Tasks`` of ``N`` robots and ``K`` orders and returns ``[N]`` intp: the column
of the order of each robot, or ``NONE``. No order is given to two robots, and none to a robot that
cannot reach it.

Example:
    >>> from agents.mapf.assignment import ASSIGNMENTS
    >>> list(ASSIGNMENTS)
    ['fifo', 'nearest', 'hungarian', 'urgent']
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.tables import Integers

__all__ = ["ASSIGNMENTS", "Tasks"]

NONE = -1
"""Number in place of an order, robot, charger or cell where there is none."""

OUT_OF_REACH = 1e9
"""Cost in place of an infinite one, which ``linear_sum_assignment`` does not take."""

STRETCH = 1.15
"""Steps that a robot among others takes for each step of the shortest way."""

HANDLING = 2
"""Steps of picking and dropping."""

URGENT, LATE = 30.0, 15.0
"""Detour in steps that an order without spare time is worth; detour that a late order costs."""

KEEP = 3.0
"""Steps by which another order must be better before a robot leaves the order it goes for.

Without it, robots would change orders at every tie.
"""

SPARE = 40.0
"""Spare steps of an order with which it is worth ``exp(-1)`` of ``URGENT``."""


class Tasks(NamedTuple):
    """Robots that wait for an order and orders that wait for a robot.

    Attributes:
        ways: ``[N, K]``, the time of each robot to the pickup of each order, infinite where it
            cannot or must not take the order. A unit of time is a cell at top speed, on the grid a
            step.
        trips: ``[K]``, the times from pickup to dropoff.
        due: ``[K]``, the time by which each is due. Orders are in order of release.
        now: present time.
        held: ``[N]``, the order that each robot goes for already, or ``NONE``.

    Example:
        >>> import numpy as np
        >>> from agents.mapf.assignment import ASSIGNMENTS, NONE, Tasks
        >>> ways, trips = np.array([[2.0, 9.0], [3.0, 5.0]]), np.array([4.0, 4.0])
        >>> tasks = Tasks(ways, trips, due=np.array([90, 20]), now=0, held=np.array([NONE, NONE]))
        >>> ASSIGNMENTS["hungarian"](tasks)
        array([0, 1])
    """

    ways: NDArray[np.floating]
    trips: NDArray[np.floating]
    due: NDArray[np.floating]
    now: float
    held: Integers


Assignment = Callable[[Tasks], NDArray[np.intp]]


def first_in_first_out(tasks: Tasks) -> NDArray[np.intp]:
    """Give the oldest orders away, each to the robot nearest to it that has none."""
    ways = np.array(tasks.ways, np.float64)
    found = np.full(len(ways), NONE)
    for order in range(ways.shape[1]):
        if not (found == NONE).any():
            break
        robot = int(ways[:, order].argmin())
        if np.isfinite(ways[robot, order]):
            found[robot], ways[robot] = order, np.inf
    return found


def nearest_first(tasks: Tasks) -> NDArray[np.intp]:
    """Give the nearest pair of robot and order to each other, then the nearest of the rest.

    Pairs that are nearest to each other are taken at once, which has the same result.
    """
    ways = np.array(tasks.ways, np.float64)
    found = np.full(len(ways), NONE)
    while np.isfinite(ways).any():
        order_of, robot_of = ways.argmin(axis=1), ways.argmin(axis=0)
        robots = np.flatnonzero(robot_of[order_of] == np.arange(len(ways)))
        robots = robots[np.isfinite(ways[robots, order_of[robots]])]
        found[robots] = order_of[robots]
        ways[robots], ways[:, found[robots]] = np.inf, np.inf
    return found


def hungarian(tasks: Tasks) -> NDArray[np.intp]:
    """Give away as many orders as can be, so that the sum of the ways is least.

    Source: Kuhn (1955), The Hungarian method for the assignment problem. SciPy's solver follows
    Crouse (2016), On implementing 2D rectangular assignment algorithms.
    """
    return _cheapest(tasks, tasks.ways)


def urgent(tasks: Tasks) -> NDArray[np.intp]:
    """Return ``hungarian`` where an order that is soon due seems nearer than it is.

    What it seems nearer by grows as its spare time gets less, to ``URGENT`` steps. An order which a
    robot cannot deliver in time any more seems farther to it, by ``LATE`` steps.
    """
    needed = STRETCH * (tasks.ways + tasks.trips) + HANDLING
    spare = tasks.due - tasks.now - needed
    # Versions of NumPy differ in the last bit of an exponential, which would decide between ties.
    near = np.round(np.exp(-np.maximum(spare, 0) / SPARE), 6)
    worth = np.where(spare < 0, -LATE, URGENT * near)
    return _cheapest(tasks, tasks.ways - worth)


def _cheapest(tasks: Tasks, costs: NDArray[np.floating]) -> NDArray[np.intp]:
    found = np.full(len(costs), NONE)
    reachable = np.isfinite(costs)
    costs = np.where(reachable, costs, OUT_OF_REACH)
    held = np.flatnonzero(tasks.held != NONE)
    costs[held, tasks.held[held]] -= KEEP
    robots, orders = cheapest_matching(costs)
    given = reachable[robots, orders]
    found[robots[given]] = orders[given]
    return found


def cheapest_matching(costs: NDArray[np.floating]) -> tuple[Integers, Integers]:
    """Return the rows and the columns of a matching with the least sum of costs.

    As many are matched as there are rows or columns, whichever are fewer; rows ascend. SciPy finds
    the matching where it is installed. Where it is not, as in a browser, the same steps in Python
    find the same one, ties included.

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
    """Return the column of each row, ``[N]``; there are no more rows than columns.

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
            # Of equally near columns the last that is free is taken, else the first.
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
