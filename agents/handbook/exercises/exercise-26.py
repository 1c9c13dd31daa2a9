"""Exercise 26: two robots in a corridor."""

from collections import deque

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def fewest_steps(grid, starts, goals):
    """Return the fewest steps until both robots are at their goals, or -1 if that is impossible.

    grid: strings of equal length. "#" is a wall; the outermost cells are walls.
    starts, goals: two cells each, one for the first robot and one for the second.

    In each step, a robot moves to an adjacent cell or stays where it is. The robots are never in
    the same cell, and they never change places in a step.
    """
    # Write here: the search of exercise 12, where a state consists of the cells of both robots.
    return None
