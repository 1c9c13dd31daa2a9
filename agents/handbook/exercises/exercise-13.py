"""Exercise 13: search with a partial map."""

from collections import deque

MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}
FAR = 40


def first_move(here, goal, walls):
    """Return the first move of a shortest path, or "WAIT" if the goal is unreachable.

    All cells are free, except for walls and for cells more than FAR rows or columns from (0, 0).
    """
    # Write here: the search of exercise 12, which also remembers the first move to each cell.
    return "WAIT"


class Explorer:
    def reset(self):
        self.walls = set()

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        # Write here: add the walls of observation["local_grid"] to self.walls, as in exercise 11.
        if here == goal:
            return "DROP" if has_item else "PICK"
        return first_move(here, goal, self.walls)
