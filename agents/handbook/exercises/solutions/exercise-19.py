"""Exercise 19: the highest expected utility."""


def expected_utility(outcomes):
    """Return the expected utility of an action."""
    return sum(probability * utility for probability, utility in outcomes)


def best_action(actions):
    """Return the action with the highest expected utility (the first, if several have it)."""
    return max(actions, key=lambda action: expected_utility(actions[action]))
