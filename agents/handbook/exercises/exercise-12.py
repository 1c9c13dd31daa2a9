"""Exercise 12: breadth-first search."""

from collections import deque

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def fewest_moves(grid, start, goal):
    """Return the fewest moves from start to goal, or -1 if the goal is unreachable.

    grid: strings of equal length. "#" is a wall; the outermost cells are walls.
    """
    moves_to = {start: 0}  # the fewest moves to each cell reached so far
    frontier = deque([start])
    # Write here: take the first cell of the frontier, and add its new neighbours at the end.
    return None
