"""Exercise 11: remember the map."""


def walls_seen(looks):
    """Return all walls that the robot has seen, as a sorted list of cells (row, column).

    looks: the observations so far, each as (robot_pos, local_grid). local_grid has an odd number
        of strings, and the robot is in the middle.
    """
    walls = set()
    for (row, column), local_grid in looks:
        radius = len(local_grid) // 2
        # Write here: add the cell of each "#" in local_grid to walls.
    return sorted(walls)
