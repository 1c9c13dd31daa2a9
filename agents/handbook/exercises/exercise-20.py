"""Exercise 20: value iteration."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))


def values(grid, slip, gamma, sweeps):
    """Return the values of all open cells, row by row, after the given number of sweeps.

    grid: strings of equal length. "#" is a wall, "D" the dropoff; the outermost cells are walls.
    slip: probability that a move slips to a side, equally often to the left and to the right.
    gamma: discount factor.

    Each move costs 0.1. A move that ends on "D" also earns 10 and ends the episode, so the value of
    "D" stays 0. A move into a wall leaves the robot where it is. All values are 0 at first. Each
    sweep computes new values from the values of the previous sweep.
    """
    cells = [
        (row, column)
        for row, line in enumerate(grid)
        for column, tile in enumerate(line)
        if tile != "#"
    ]
    value = dict.fromkeys(cells, 0.0)
    # Write here.
    return [value[cell] for cell in cells]
