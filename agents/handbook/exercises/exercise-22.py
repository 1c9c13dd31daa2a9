"""Exercise 22: what Q-learning learns from one step."""


def updated(values, action, reward, next_values, ended, alpha, gamma):
    """Return the new value of an action after one step.

    values: the value of each action in the state before the step.
    action: the index of the action taken.
    reward: the reward of the step.
    next_values: the value of each action in the state after the step.
    ended: True if the step ended the episode, so that no state follows.
    alpha, gamma: learning rate and discount factor.
    """
    # Write here.
    return values[action]


def choose(values, epsilon, chance, random_action):
    """Return the index of a random action or of the best one (the first, if several are best).

    epsilon: the share of random actions.
    chance: a random number from 0 up to 1. If it is less than epsilon, take the random action.
    random_action: the index of the random action.
    """
    # Write here.
    return -1
