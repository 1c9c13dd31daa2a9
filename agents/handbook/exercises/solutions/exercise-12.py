"""Exercise 12: breadth-first search."""

from collections import deque

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def fewest_moves(grid, start, goal):
    """Return the fewest moves from start to goal, or -1 if the goal is unreachable."""
    moves_to = {start: 0}  # the fewest moves to each cell reached so far
    frontier = deque([start])
    while frontier:
        cell = frontier.popleft()
        if cell == goal:
            return moves_to[cell]
        for down, right in MOVES.values():
            there = cell[0] + down, cell[1] + right
            if grid[there[0]][there[1]] != "#" and there not in moves_to:
                moves_to[there] = moves_to[cell] + 1
                frontier.append(there)
    return -1
