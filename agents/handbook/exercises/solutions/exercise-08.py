"""Exercise 8: follow the wall."""

LEFT_OF = {"N": "W", "W": "S", "S": "E", "E": "N"}
RIGHT_OF = {left: move for move, left in LEFT_OF.items()}
BEHIND = {"N": "S", "S": "N", "E": "W", "W": "E"}
MOVES = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}


def open_moves(local_grid):
    middle = len(local_grid) // 2
    return [
        move
        for move, (down, right) in MOVES.items()
        if local_grid[middle + down][middle + right] != "#"
    ]


class WallFollower:
    def reset(self):
        self.heading = "N"  # the previous move: the state of the agent

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        if here == observation["dropoff_pos"] and has_item:
            return "DROP"
        if here == observation["pickup_pos"] and not has_item:
            return "PICK"
        moves = open_moves(observation["local_grid"])
        ahead = self.heading
        for move in (RIGHT_OF[ahead], ahead, LEFT_OF[ahead], BEHIND[ahead]):
            if move in moves:
                self.heading = move
                return move
        return "WAIT"
