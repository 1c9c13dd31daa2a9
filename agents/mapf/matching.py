"""The cheapest matching of rows to columns, such as of robots to orders."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warehouse_core.world.tables import Integers

FREE = -1
"""Stands for a row or a column that is not matched."""


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
    row_of, column_of = np.full(columns, FREE), np.full(rows, FREE)
    for start in range(rows):
        shortest, path = np.full(columns, np.inf), np.full(columns, FREE)
        remaining = np.arange(columns)[::-1].copy()
        row, lowest, seen = start, 0.0, [start]
        while True:
            reached = lowest + costs[row, remaining] - row_price[row] - column_price[remaining]
            is_shorter = reached < shortest[remaining]
            shortest[remaining[is_shorter]] = reached[is_shorter]
            path[remaining[is_shorter]] = row
            lowest = shortest[remaining].min()
            nearest = np.flatnonzero(shortest[remaining] == lowest)
            free = nearest[row_of[remaining[nearest]] == FREE]
            # Of equally near columns the last that is free is taken, else the first.
            index = free[-1] if len(free) else nearest[0]
            column, remaining[index] = remaining[index], remaining[-1]
            remaining = remaining[:-1]
            if row_of[column] == FREE:
                break
            row = row_of[column]
            seen.append(row)
        others = seen[1:]
        row_price[start] += lowest
        row_price[others] += lowest - shortest[column_of[others]]
        scanned = np.setdiff1d(np.arange(columns), remaining)
        column_price[scanned] -= lowest - shortest[scanned]
        while column != FREE:
            row = path[column]
            row_of[column] = row
            column, column_of[row] = column_of[row], column
    return column_of
