"""Exercise 21: a slippery floor."""

from collections import deque

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}
FAR = 40


def way(here, goal, walls):
    """Return the moves of a shortest way, None if there is none."""
    before = {here: None}  # the cell and the move before each cell that was reached
    frontier = deque([here])
    while frontier:
        cell = frontier.popleft()
        if cell == goal:
            moves = []
            while before[cell]:
                cell, move = before[cell]
                moves.insert(0, move)
            return moves
        for move, (down, right) in MOVES.items():
            there = cell[0] + down, cell[1] + right
            is_near = max(abs(there[0]), abs(there[1])) <= FAR
            if is_near and there not in walls and there not in before:
                before[there] = cell, move
                frontier.append(there)
    return None


class Sure:
    def reset(self):
        self.walls = set()

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        radius = len(observation["local_grid"]) // 2
        for down, line in enumerate(observation["local_grid"]):
            for right, tile in enumerate(line):
                cell = here[0] + down - radius, here[1] + right - radius
                if tile == "#":
                    self.walls.add(cell)
        # Write here. This drives the shortest way, from where the robot is and not from where it
        # should be. It does not mind that moves slip, and that each slip into a wall costs 1. Drive
        # by the highest expected utility instead, with the values of exercise 20.
        if here == goal:
            return "DROP" if has_item else "PICK"
        moves = way(here, goal, self.walls)
        return moves[0] if moves else "WAIT"
