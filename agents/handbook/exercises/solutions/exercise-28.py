"""Exercise 28: slow down for corners."""

import math


def speed_before(metres, speed, braking):
    """Return the largest speed from which a robot can brake to a lower one."""
    return math.sqrt(speed**2 + 2 * braking * metres)


def speed_limits(path, corner, braking, top):
    """Return the largest allowed speed in m/s in each cell of a path."""
    limits = [top for cell in path]
    for at in range(1, len(path) - 1):
        (row, column), (to_row, to_column) = path[at - 1], path[at + 1]
        if row != to_row and column != to_column:
            limits[at] = min(corner, top)
    limits[-1] = 0.0
    for at in range(len(path) - 2, -1, -1):
        limits[at] = min(limits[at], speed_before(1.0, limits[at + 1], braking))
    return limits
