"""Exercise 26: two robots in a corridor."""

from collections import deque

MOVES = ((-1, 0), (0, 1), (1, 0), (0, -1), (0, 0))


def fewest_steps(grid, starts, goals):
    """Return the fewest steps until both robots are at their goals, or -1 if that is impossible."""

    def next_cells(cell):
        cells = [(cell[0] + down, cell[1] + right) for down, right in MOVES]
        return [(row, column) for row, column in cells if grid[row][column] != "#"]

    steps_to, frontier = {starts: 0}, deque([starts])
    while frontier:
        state = frontier.popleft()
        if state == goals:
            return steps_to[state]
        for first in next_cells(state[0]):
            for second in next_cells(state[1]):
                if first == second or (first, second) == (state[1], state[0]):
                    continue
                if (first, second) not in steps_to:
                    steps_to[first, second] = steps_to[state] + 1
                    frontier.append((first, second))
    return -1
