"""Exercise 27: a proportional controller."""

import math

SPEEDING, TURNING = 0.8, 0.4


def command(ahead, right):
    """Return the speed and the turn rate of a robot, two numbers from -1 to 1.

    ahead, right: the goal is this many metres ahead of the robot and to its right.

    The turn rate is TURNING for each radian between the heading and the goal, positive to the
    right. The speed is SPEEDING for each metre of distance, times the cosine of this angle, so that
    the robot turns first. It never drives backwards. Both numbers are limited to -1 and 1.
    """
    # Write here: the angle from math.atan2, and the distance from math.hypot.
    return 0.0, 0.0
