"""Exercise 1: the performance measure."""


def reward(action, tile, has_item, blocked):
    """Return the reward of a step."""
    if action in ("N", "E", "S", "W"):
        return -0.1 - (1.0 if blocked else 0.0)
    if action == "WAIT":
        return -0.1 - 0.05
    if action == "PICK" and tile == "P" and not has_item:
        return -0.1 + 5.0
    if action == "DROP" and tile == "D" and has_item:
        return -0.1 + 10.0
    return -0.1 - 0.5
