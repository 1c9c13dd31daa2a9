"""Exercise 16: a heuristic for the whole delivery."""


def distance(cell, other):
    return abs(cell[0] - other[0]) + abs(cell[1] - other[1])


def heuristic(here, has_item, pickups, dropoffs):
    """Return the fewest steps to the delivery without walls, including PICK and DROP."""

    def deliver(cell):
        return min(distance(cell, dropoff) for dropoff in dropoffs) + 1

    if has_item:
        return deliver(here)
    return min(distance(here, pickup) + 1 + deliver(pickup) for pickup in pickups)
