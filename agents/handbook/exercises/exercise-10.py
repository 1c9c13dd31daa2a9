"""Exercise 10: out of the loop."""

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def distance(cell, other):
    return abs(cell[0] - other[0]) + abs(cell[1] - other[1])


def after(here, move):
    """Return the cell that a move leads to."""
    return here[0] + MOVES[move][0], here[1] + MOVES[move][1]


def open_moves(local_grid):
    middle = len(local_grid) // 2
    return [
        move
        for move, (down, right) in MOVES.items()
        if local_grid[middle + down][middle + right] != "#"
    ]


class Escaping:
    def reset(self):
        self.visits = {}  # number of visits to each cell since the robot has had this goal
        self.had_item = False

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        if has_item != self.had_item:
            self.visits, self.had_item = {}, has_item
        if here == goal:
            return "DROP" if has_item else "PICK"
        self.visits[here] = self.visits.get(here, 0) + 1
        moves = open_moves(observation["local_grid"])
        # Write here. This takes the move that leads nearest to the goal, and can end in a loop.
        return min(moves, key=lambda move: distance(after(here, move), goal))
