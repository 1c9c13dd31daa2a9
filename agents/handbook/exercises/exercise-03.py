"""Exercise 3: what the robot sees."""


def open_moves(local_grid):
    """Return the moves that no wall stops, in the order "N", "E", "S", "W".

    local_grid: equally many strings and characters, an odd number; the robot is in the middle.
    """
    # Write here. The robot is at local_grid[middle][middle].
    middle = len(local_grid) // 2
    return []
