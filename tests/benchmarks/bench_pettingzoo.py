"""A large fleet as dictionaries of PettingZoo."""

from time import process_time

import numpy as np

from warehouse_core.pettingzoo_env import parallel_env
from warehouse_core.world.generators import shelf_layout

LAYOUT = shelf_layout(68, 99, 4)
"""139 x 498 cells."""

ROBOTS, STEPS, ROUNDS = 1_000, 40, 5
MIN_RATE = 200_000


def test_a_thousand_robots_as_dictionaries(measured) -> None:
    """Of processor time, on a map of 140 x 500, with orders, views of 5 x 5 and masks."""
    env = parallel_env(LAYOUT, ROBOTS, 10**6, battery=10**6, orders=20.0 / 10**3)
    env.reset(seed=0)
    stream = np.random.default_rng(0)
    chosen = stream.integers(7, size=(STEPS, ROBOTS)).tolist()
    joint = [dict(zip(env.agents, actions, strict=True)) for actions in chosen]

    def rate() -> float:
        start = process_time()
        for actions in joint:
            env.step(actions)
        return STEPS * ROBOTS / (process_time() - start)

    rate()
    best = max(rate() for _ in range(ROUNDS))
    measured("PettingZoo dicts, 1,000 robots on 140 x 500, robot-steps/s", f"{best:,.0f}")
    assert best >= MIN_RATE
