"""Exercise 1: the performance measure."""


def reward(action, tile, has_item, blocked):
    """Return the reward of a step.

    action: "N", "E", "S", "W", "WAIT", "PICK", "DROP" or another word.
    tile: "P", "D" or ".", the cell under the robot.
    has_item: True if the robot had the item before the step.
    blocked: True if a wall stopped the move.
    """
    # Write here. The reward of a move into a free cell is already right.
    return -0.1
