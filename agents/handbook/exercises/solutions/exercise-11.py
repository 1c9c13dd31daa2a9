"""Exercise 11: remember the map."""


def walls_seen(looks):
    """Return all walls that the robot has seen, as a sorted list of cells (row, column)."""
    walls = set()
    for (row, column), local_grid in looks:
        radius = len(local_grid) // 2
        for down, line in enumerate(local_grid):
            for right, tile in enumerate(line):
                if tile == "#":
                    walls.add((row + down - radius, column + right - radius))
    return sorted(walls)
