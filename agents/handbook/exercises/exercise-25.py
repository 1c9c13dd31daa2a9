"""Exercise 25: who gives way? One step of PIBT."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def next_cells(grid, cells, goals):
    """Return the next cell of each robot.

    grid: equally long strings, "#" is a wall; the outermost cells are walls.
    cells, goals: a cell for each robot. The first robot has the highest priority.

    A robot that chooses prefers the cell with the lowest Manhattan distance to its goal; of several
    it prefers the first of north, east, south, west and staying. It passes over walls, cells that
    are chosen already, and the cell of a robot that has chosen this one's own cell: two robots
    cannot change places. If an undecided robot is in the cell, that robot has to choose now; if it
    finds none, the next cell is tried. A robot that finds no cell stays, and has failed.
    """
    next_of = {}  # the cell that each robot has chosen, by the number of the robot

    def choose(robot):
        """Choose a cell for a robot, and return whether there was one."""
        # Write here. This lets each robot drive as if it were alone.
        row, column = cells[robot]
        goal_row, goal_column = goals[robot]
        free = [(row + down, column + right) for down, right in MOVES]
        free = [cell for cell in free if grid[cell[0]][cell[1]] != "#"]
        next_of[robot] = min(
            free, key=lambda cell: abs(cell[0] - goal_row) + abs(cell[1] - goal_column)
        )
        return True

    for robot in range(len(cells)):
        if robot not in next_of:
            choose(robot)
    return [next_of[robot] for robot in range(len(cells))]
