"""Exercise 22: what Q-learning learns from one step."""


def updated(values, action, reward, next_values, ended, alpha, gamma):
    """Return the new value of an action after one step.

    values: the value of each action in the state of the robot.
    action: index of the action that it took.
    reward: reward of the step.
    next_values: the value of each action in the state after it.
    ended: True if the step ended the episode: then nothing comes after it.
    alpha, gamma: learning rate and discount factor.
    """
    # Write here.
    return values[action]


def choose(values, epsilon, chance, random_action):
    """Return the index of an action: a random one or the best, the first of several.

    epsilon: share of random actions.
    chance: a random number from 0 up to 1; if it is less than epsilon, the action is random.
    random_action: index of the random action.
    """
    # Write here.
    return -1
