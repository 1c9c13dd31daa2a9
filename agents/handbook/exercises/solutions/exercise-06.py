"""Exercise 6: around obstacles, without a bump."""

import random

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


class Careful:
    def __init__(self, seed=None):
        self.seed = seed

    def reset(self):
        self.random = random.Random(self.seed)

    def act(self, observation):
        here, has_item = observation["robot_pos"], observation["has_item"]
        goal = observation["dropoff_pos"] if has_item else observation["pickup_pos"]
        if here == goal:
            return "DROP" if has_item else "PICK"
        moves = open_moves(observation["local_grid"])
        nearer = [
            move for move in moves if distance(after(here, move), goal) < distance(here, goal)
        ]
        # An occasional random move, so that the robot does not stay in a corner forever.
        if not nearer or self.random.random() < 0.2:
            return self.random.choice(moves or ["WAIT"])
        return self.random.choice(nearer)
