"""Exercise 25: who gives way? One step of PIBT."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def next_cells(grid, cells, goals):
    """Return the next cell of each robot."""
    next_of = {}  # the cell that each robot has chosen, by the robot's number

    def choose(robot):
        """Choose a cell for a robot, and return whether it found one."""
        row, column = cells[robot]
        goal_row, goal_column = goals[robot]
        free = [(row + down, column + right) for down, right in MOVES]
        free = [cell for cell in free if grid[cell[0]][cell[1]] != "#"]
        free.sort(key=lambda cell: abs(cell[0] - goal_row) + abs(cell[1] - goal_column))
        for cell in free:
            if cell in next_of.values():
                continue
            other = cells.index(cell) if cell in cells else robot
            if next_of.get(other) == cells[robot]:
                continue  # the two robots would change places
            next_of[robot] = cell
            if other == robot or other in next_of or choose(other):
                return True
        next_of[robot] = cells[robot]
        return False

    for robot in range(len(cells)):
        if robot not in next_of:
            choose(robot)
    return [next_of[robot] for robot in range(len(cells))]
