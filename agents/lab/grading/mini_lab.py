"""The agent of the mini-lab, to be made better.

Watch it: warehouse run --agent my_agent.py --seed 1
Grade it: warehouse grade my_agent.py
"""

import random


class MyAgent:
    """Moves at random, and picks up and delivers where it happens to come by."""

    def __init__(self, seed=None):
        self.random = random.Random(seed)

    def reset(self):
        """Begin an episode. What the agent remembers of the last one must go."""

    def act(self, observation):
        """Return N, E, S, W, WAIT, PICK or DROP for what the robot perceives.

        observation["local_grid"] has the rows around the robot, which is in their middle: "#" is a
        wall. Positions are (row, column), and row 0 is at the top.
        """
        here = observation["robot_pos"]
        goal = observation["dropoff_pos" if observation["has_item"] else "pickup_pos"]
        if here == goal:
            return "DROP" if observation["has_item"] else "PICK"
        # Here is your part: which move brings the robot to its goal?
        return self.random.choice("NESW")
