"""Exercise 9: am I in a loop?"""


def is_looping(cells, memory):
    """Return True if the last cell is among the `memory` cells right before it.

    cells: all cells of the robot so far. It is now in the last one.
    memory: how many of the cells before it the robot remembers, 0 or more.
    """
    # Write here.
    return None


def loop_length(cells):
    """Return how many steps ago the robot was previously on its last cell, or 0 if it never was."""
    # Write here.
    return None
