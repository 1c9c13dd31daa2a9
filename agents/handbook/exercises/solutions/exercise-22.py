"""Exercise 22: what Q-learning learns from one step."""


def updated(values, action, reward, next_values, ended, alpha, gamma):
    """Return the new value of an action after one step."""
    future = 0.0 if ended else gamma * max(next_values)
    return values[action] + alpha * (reward + future - values[action])


def choose(values, epsilon, chance, random_action):
    """Return the index of a random action or of the best one (the first, if several are best)."""
    if chance < epsilon:
        return random_action
    return list(values).index(max(values))
