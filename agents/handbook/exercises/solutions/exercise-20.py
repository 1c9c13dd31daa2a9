"""Exercise 20: value iteration."""

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1))


def values(grid, slip, gamma, sweeps):
    """Return the values of all open cells, row by row, after the given number of sweeps."""
    cells = [
        (row, column)
        for row, line in enumerate(grid)
        for column, tile in enumerate(line)
        if tile != "#"
    ]
    value = dict.fromkeys(cells, 0.0)

    def worth(cell, move):
        """Return the reward of one move that does not slip, plus the discounted value after it."""
        there = cell[0] + move[0], cell[1] + move[1]
        if there not in value:
            there = cell
        arrived = grid[there[0]][there[1]] == "D"
        return -0.1 + (10.0 if arrived else 0.0) + gamma * value[there]

    def expected(cell, move):
        down, right = move
        sides = worth(cell, (right, -down)) + worth(cell, (-right, down))
        return (1 - slip) * worth(cell, move) + slip / 2 * sides

    for _ in range(sweeps):
        value = {
            cell: 0.0
            if grid[cell[0]][cell[1]] == "D"
            else max(expected(cell, move) for move in MOVES)
            for cell in cells
        }
    return [value[cell] for cell in cells]
