"""Exercise 24: which robot takes which order?"""

from itertools import permutations


def assign(steps):
    """Return one order for each robot, so that the sum of their steps is as small as possible."""

    def total(orders):
        return sum(row[order] for row, order in zip(steps, orders))

    return min(permutations(range(len(steps))), key=total)
