"""Exercise 3: what the robot sees."""

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def open_moves(local_grid):
    """Return the moves that no wall blocks, in the order "N", "E", "S", "W"."""
    middle = len(local_grid) // 2
    return [
        move
        for move, (down, right) in MOVES.items()
        if local_grid[middle + down][middle + right] != "#"
    ]
