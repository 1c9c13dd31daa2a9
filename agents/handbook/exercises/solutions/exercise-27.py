"""Exercise 27: a proportional controller."""

import math

SPEEDING, TURNING = 0.8, 0.4


def command(ahead, right):
    """Return the speed and the turn rate of a robot, two numbers from -1 to 1."""
    angle = math.atan2(right, ahead)
    speed = SPEEDING * math.hypot(ahead, right) * max(math.cos(angle), 0.0)
    return min(speed, 1.0), max(-1.0, min(TURNING * angle, 1.0))
