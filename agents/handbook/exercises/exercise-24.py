"""Exercise 24: which robot takes which order?"""


def assign(steps):
    """Return one order for each robot, so that the sum of their steps is as small as possible.

    steps: a row for each robot, with its number of steps to each order. There are as many orders
        as robots, at most six. Each robot gets one order, and no two robots get the same.
    """
    # Write here. One robot after the other takes the nearest order that is left.
    taken = []
    for row in steps:
        left = [order for order in range(len(row)) if order not in taken]
        taken.append(min(left, key=lambda order: row[order]))
    return taken
