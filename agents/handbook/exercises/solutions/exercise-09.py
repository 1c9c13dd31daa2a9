"""Exercise 9: am I in a loop?"""


def is_looping(cells, memory):
    """Return True if the last cell is among the `memory` cells right before it."""
    *before, here = cells
    return here in before[max(len(before) - memory, 0) :]


def loop_length(cells):
    """Return how many steps ago the robot was previously on its last cell, or 0 if it never was."""
    *before, here = cells
    for steps, cell in enumerate(reversed(before), start=1):
        if cell == here:
            return steps
    return 0
