"""Exercise 15: uniform-cost search."""

import heapq

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def lowest_cost(grid, start, goal):
    """Return the lowest cost of a path from start to goal, or -1 if the goal is unreachable.

    grid: strings of equal length. "#" is a wall; the outermost cells are walls. A digit is the
        cost of a move into that cell. The start costs nothing.
    """
    cost_of = {start: 0}  # the lowest known cost to each cell reached so far
    frontier = [(0, start)]  # a heap: heapq.heappop(frontier) takes the cheapest
    # Write here.
    return None
