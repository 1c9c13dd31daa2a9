"""Exercise 17: A* search."""

import heapq

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def astar(grid, start, goal):
    """Return the fewest moves from start to goal, and how many cells the search expanded."""

    def entry(cell, g):
        h = abs(cell[0] - goal[0]) + abs(cell[1] - goal[1])
        return g + h, h, cell, g

    frontier, best, expanded = [entry(start, 0)], {start: 0}, 0
    while frontier:
        _, _, cell, g = heapq.heappop(frontier)
        if cell == goal:
            return g, expanded
        if g > best[cell]:
            continue  # outdated: a shorter path to this cell has been found since
        expanded += 1
        for down, right in MOVES.values():
            there = cell[0] + down, cell[1] + right
            if grid[there[0]][there[1]] != "#" and g + 1 < best.get(there, float("inf")):
                best[there] = g + 1
                heapq.heappush(frontier, entry(there, g + 1))
    return None
