"""Exercise 23: a robot that has learned its floor, and drives blind."""

import random

from warehouse_core import WarehouseEnv
from warehouse_core.world.named_layouts import named_layout

ACTIONS = ["N", "E", "S", "W", "WAIT", "PICK", "DROP"]
ALPHA, GAMMA, EPSILON = 0.5, 0.95, 0.1


def learn(steps, seed):
    """Return a table of learned values, a list of seven numbers for each (cell, has_item)."""
    env, stream, table = WarehouseEnv(named_layout("trap")), random.Random(seed), {}

    def values_of(observation):
        state = observation["robot_pos"], observation["has_item"]
        return table.setdefault(state, [0.0] * len(ACTIONS))

    while steps > 0:
        values, done = values_of(env.reset("start", stream.randrange(10**6))), False
        while not done:
            if stream.random() < EPSILON:
                action = stream.randrange(len(ACTIONS))
            else:
                action = values.index(max(values))
            observation, reward, terminated, truncated, _ = env.step(action)
            next_values, done = values_of(observation), terminated or truncated
            future = 0.0 if terminated else GAMMA * max(next_values)
            values[action] += ALPHA * (reward + future - values[action])
            values = next_values
            steps -= 1
    return table


TABLE = learn(steps=20_000, seed=1)


class Learned:
    def reset(self):
        pass

    def act(self, observation):
        state = observation["robot_pos"], observation["has_item"]
        values = TABLE.get(state, [0.0] * len(ACTIONS))
        return ACTIONS[values.index(max(values))]
