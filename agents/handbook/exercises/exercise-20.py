"""Exercise 20: value iteration."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))


def values(grid, slip, gamma, sweeps):
    """Return the value of each open cell, row by row, after so many sweeps.

    grid: equally long strings. "#" is a wall, "D" the dropoff; the outermost cells are walls.
    slip: chance that a move goes to a side, half of it to the left and half to the right.
    gamma: discount factor.

    Each move costs 0.1. A move that ends on "D" earns 10 more, and ends the episode: the value of
    "D" stays 0. A move against a wall leaves the robot where it is. All values are 0 at first.
    Each sweep computes new values from the values of the sweep before.
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
