"""A program that prints the steps per second with random actions and with an agent."""

import random
from collections.abc import Callable
from time import perf_counter

from agents import GreedyAgent
from warehouse_core import WarehouseEnv

ROUNDS, STEPS = 5, 20_000

Act = Callable[[object], object]


def random_actions() -> Act:
    """Return a function that ignores what it observes."""
    actions = iter(random.Random(0).choices(WarehouseEnv.ACTIONS, k=STEPS))
    return lambda observation: next(actions)


def greedy_actions() -> Act:
    """Return the ``act`` of an agent, which is not reset between episodes."""
    agent = GreedyAgent(seed=0)
    agent.reset()
    return agent.act


def steps_a_second(act: Act) -> float:
    """Return the steps per second of one round."""
    env = WarehouseEnv()
    observation, start = env.reset(randomize=True, seed=0), perf_counter()
    for _ in range(STEPS):
        observation, _, terminated, truncated, _ = env.step(act(observation))
        if terminated or truncated:
            observation = env.reset(randomize=True)
    return STEPS / (perf_counter() - start)


if __name__ == "__main__":
    for make in (random_actions, greedy_actions):
        print(max(steps_a_second(make()) for _ in range(ROUNDS)))
