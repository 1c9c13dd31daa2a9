"""Tabular Q-learning: the value of each action in each state, learned from rewards alone.

After every step from state S by action A, with reward R, to state S',

    Q(S, A)  <-  Q(S, A) + alpha * (R + gamma * max Q(S', a) - Q(S, A))
                                            a

A state is (the robot's cell, its goal's cell, whether it holds the item). A table is for one
layout: in another one the same cells have other neighbours.

Source: Sutton and Barto, *Reinforcement Learning*, 2nd ed., 2018, sec. 6.5; Russell and Norvig,
4th ed., 2020, ch. 22, temporal-difference Q-learning.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

from agents.warehouse_agent_greedy import goal_of
from warehouse_core.arguments import instance_of, seed_number
from warehouse_core.task.encoding import NOWHERE
from warehouse_core.task.state import Observation
from warehouse_core.warehouse_env import WarehouseEnv
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import Cell

__all__ = ["QAgent", "QTable", "best_action", "learn", "state_of"]

ALPHA = 0.1
"""The learning rate.

A lower one averages better over the possible next goals; a higher one learns faster.
"""

GAMMA = 0.95
"""The discount factor, which makes a short path better than a long one."""

EPSILON = 0.1
"""The share of random actions, for exploration."""

TRAINING_SEEDS = 1_000_000
"""Limit of seeds: episodes of a training have lower seeds, and evaluations have higher ones."""

QState = tuple[Cell, Cell, bool]


class QTable(dict[QState, list[float]]):
    """The values of all actions by state; they are 0 in a new state.

    Example:
        >>> from agents.learning import QTable
        >>> table = QTable()
        >>> table["a new state"]
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """

    def __missing__(self, state: QState) -> list[float]:
        values = self[state] = [0.0] * len(ACTIONS)
        return values


def state_of(observation: Observation) -> QState:
    """Return the state of an observation.

    Example:
        >>> from agents.learning.q_learning import state_of
        >>> from warehouse_core import WarehouseEnv
        >>> state_of(WarehouseEnv().reset())
        ((1, 1), (1, 3), False)
    """
    return observation["robot_pos"], goal_of(observation) or NOWHERE, observation["has_item"]


def best_action(values: list[float], stream: random.Random) -> int:
    """Return the action with the highest value, or a random one among several such actions.

    Example:
        >>> import random
        >>> from agents.learning.q_learning import best_action
        >>> best_action([0.0, 2.5, 1.0], random.Random(1))
        1
    """
    highest = max(values)
    best = [action for action, value in enumerate(values) if value == highest]
    return best[0] if len(best) == 1 else stream.choice(best)


def learn(
    table: QTable,
    env: WarehouseEnv,
    steps: int,
    seed: int | random.Random,
    randomize: bool | str = True,
) -> Iterator[tuple[int, bool]]:
    """Fill a table in whole episodes, with at least ``steps`` steps in total.

    ``randomize`` selects the stations and start that are random in each episode, see
    ``WarehouseEnv.reset``. A random stream can take the place of ``seed``, to continue a training.

    Yields:
        Steps so far, after each episode, and whether it ended with a delivery.

    Example:
        >>> from agents.learning import QTable
        >>> from agents.learning.q_learning import learn
        >>> from warehouse_core import WarehouseEnv
        >>> table = QTable()
        >>> deliveries = [delivered for _, delivered in learn(table, WarehouseEnv(), 5_000, seed=1)]
        >>> len(table) > 100, sum(deliveries) > 0
        (True, True)
    """
    stream, taken = seed if isinstance(seed, random.Random) else random.Random(seed), 0
    while taken < steps:
        state, done = state_of(env.reset(randomize, stream.randrange(TRAINING_SEEDS))), False
        while not done:
            explores = stream.random() < EPSILON
            values = table[state]
            action = stream.randrange(len(ACTIONS)) if explores else best_action(values, stream)
            observation, reward, terminated, truncated, _ = env.step(action)
            state, done = state_of(observation), terminated or truncated
            future = 0.0 if terminated else max(table[state])
            values[action] += ALPHA * (reward + GAMMA * future - values[action])
            taken += 1
        yield taken, terminated


class QAgent:
    """An agent that takes the action with the highest value in a table.

    Args:
        table: table of values. In a state that is missing from it, the agent acts at random.
        seed: seed of the agent's own random stream, restarted at each ``reset``.

    Example:
        >>> from agents import QAgent
        >>> from agents.learning import QTable
        >>> from warehouse_core import WarehouseEnv
        >>> agent = QAgent(QTable(), seed=1)
        >>> action = agent.act(WarehouseEnv().reset())
    """

    def __init__(self, table: QTable, seed: int | None = None) -> None:
        self.table, self.seed = instance_of("table", table, dict), seed_number(seed)
        self.reset()

    def reset(self) -> None:
        """Prepare for an episode."""
        self._random, self.reason = random.Random(self.seed), ""

    def act(self, observation: Observation) -> str:
        """Return the best action for ``observation`` and set ``reason`` to its value."""
        values = self.table.get(state_of(observation), [0.0] * len(ACTIONS))
        action = best_action(values, self._random)
        self.reason = f"worth {values[action]:.1f}"
        return ACTIONS[action]
