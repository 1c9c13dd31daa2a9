"""Exercise 25: who gives way? One step of PIBT."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def next_cells(grid, cells, goals):
    """Return the next cell of each robot.

    grid: strings of equal length. "#" is a wall; the outermost cells are walls.
    cells, goals: a cell for each robot. The first robot has the highest priority.

    A robot may go north, east, south or west, or stay. It tries these cells in the order of their
    Manhattan distance to its goal, and equally distant cells in the order given here. It skips
    walls and cells that are already chosen. It also skips the cell of a robot that has chosen this
    robot's own cell, because two robots cannot change places. If a robot that has not chosen yet is
    in the cell, that robot has to choose now. If it fails, this robot tries its next cell. A robot
    that finds no cell stays where it is, and has failed.
    """
    next_of = {}  # the cell that each robot has chosen, by the robot's number

    def choose(robot):
        """Choose a cell for a robot, and return whether it found one."""
        # Write here. This moves each robot as if it were alone.
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
