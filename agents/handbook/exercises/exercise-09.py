"""Exercise 9: am I in a loop?"""


def is_looping(cells, memory):
    """Return True if the last cell is among the `memory` cells right before it.

    cells: all cells of the robot so far, the last one is where it is now.
    memory: how many cells before it are remembered, 0 or more.
    """
    # Write here.
    return None


def loop_length(cells):
    """Return after how many steps the robot is on its last cell again; 0 if it was never there."""
    # Write here.
    return None
