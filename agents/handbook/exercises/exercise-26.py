"""Exercise 26: two robots in a corridor."""

from collections import deque

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def fewest_steps(grid, starts, goals):
    """Return the fewest steps until both robots are at their goals at once, -1 if they cannot be.

    grid: equally long strings, "#" is a wall; the outermost cells are walls.
    starts, goals: two cells each, of the first and of the second robot.

    In a step each robot moves to a cell beside it or stays. They are never in one cell, and never
    change places in a step.
    """
    # Write here: the search of exercise 12, in which a state is the cells of both robots.
    return None
