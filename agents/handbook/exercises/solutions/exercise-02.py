"""Exercise 2: how far is it?"""

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def distance(cell, other):
    """Return the Manhattan distance between two cells, each (row, column)."""
    return abs(cell[0] - other[0]) + abs(cell[1] - other[1])


def nearer_moves(here, goal):
    """Return the moves that reduce the distance to the goal, in the order "N", "E", "S", "W"."""
    moves = []
    for move, (down, right) in MOVES.items():
        there = here[0] + down, here[1] + right
        if distance(there, goal) < distance(here, goal):
            moves.append(move)
    return moves
