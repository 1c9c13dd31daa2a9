"""Exercise 15: uniform-cost search."""

import heapq

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def lowest_cost(grid, start, goal):
    """Return the lowest cost of a way from start to goal, -1 if there is no way.

    grid: equally long strings. "#" is a wall; the outermost cells are walls. A digit is the cost
        of a move into that cell. The cell of the start costs nothing.
    """
    cost_of = {start: 0}  # the cells that were reached, and the lowest cost to each so far
    frontier = [(0, start)]  # a heap: heapq.heappop(frontier) is the cheapest
    # Write here.
    return None
