"""Exercise 17: A* search."""

import heapq

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def astar(grid, start, goal):
    """Return the fewest moves from start to goal, and how many cells the search expanded.

    grid: strings of equal length. "#" is a wall; the outermost cells are walls. The goal can be
        reached.

    Expand the cell with the lowest f = g + h next, where g is the number of moves to the cell and h
    its Manhattan distance to the goal. Among cells with the same f, take the one with the lowest h,
    and among those the one with the lowest (row, column). Do not count the goal as expanded.
    """
    # Write here.
    return 0, 0
