"""Exercise 15: uniform-cost search."""

import heapq

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def lowest_cost(grid, start, goal):
    """Return the lowest cost of a path from start to goal, or -1 if the goal is unreachable."""
    cost_of = {start: 0}  # the lowest known cost to each cell reached so far
    frontier = [(0, start)]  # a heap: heapq.heappop(frontier) takes the cheapest
    while frontier:
        cost, cell = heapq.heappop(frontier)
        if cell == goal:
            return cost
        for down, right in MOVES.values():
            there = cell[0] + down, cell[1] + right
            tile = grid[there[0]][there[1]]
            if tile == "#":
                continue
            new = cost + int(tile)
            if there not in cost_of or new < cost_of[there]:
                cost_of[there] = new
                heapq.heappush(frontier, (new, there))
    return -1
