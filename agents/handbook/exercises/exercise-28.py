"""Exercise 28: slow down for corners."""

import math


def speed_before(metres, speed, braking):
    """Return the largest speed from which a robot can brake to a lower one.

    metres: the distance on which it brakes, in metres.
    speed: the speed in m/s that it has to reach.
    braking: the deceleration in m/s².
    """
    # Write here.
    return speed


def speed_limits(path, corner, braking, top):
    """Return the largest allowed speed in m/s in each cell of a path.

    path: cells (row, column), each next to the one before. Their middles are a metre apart.
    corner: the largest speed in a cell in which the path changes its direction.
    braking: the deceleration in m/s².
    top: the top speed. In the last cell, the robot stops.
    """
    # Write here: first the limits of the cells alone, and then, from the end of the path to its
    # start, what the robot needs to brake for the next cell.
    return [top for cell in path]
