"""A large fleet as dictionaries of PettingZoo."""

from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np

from warehouse_core.pettingzoo_env import parallel_env
from warehouse_core.world.generators import shelf_layout

LAYOUT = shelf_layout(68, 99, 4)
"""139 x 498 cells."""

ROBOTS, STEPS, ROUNDS = 1_000, 40, 5
MIN_SHARE = 0.12
"""Of the rate as arrays."""


def test_a_thousand_robots_as_dictionaries(measured) -> None:
    """In a second of processor time, with orders, views of 5 x 5 and masks."""
    env = parallel_env(LAYOUT, ROBOTS, 10**6, battery=10**6, orders=20.0 / 10**3)
    env.reset(seed=0)
    stream = np.random.default_rng(0)
    chosen = stream.integers(7, size=(STEPS, ROBOTS))
    joint = [dict(zip(env.agents, actions, strict=True)) for actions in chosen.tolist()]

    def rate(step: Callable[[Any], object], actions: Any) -> float:
        start = process_time()
        for each in actions:
            step(each)
        return STEPS * ROBOTS / (process_time() - start)

    rates = [(rate(env.step, joint), rate(env.fleet.step, chosen)) for _ in range(ROUNDS + 1)][1:]
    best, arrays = map(max, zip(*rates, strict=True))
    measured(
        "PettingZoo dicts, 1,000 robots on 139 x 498, robot-steps a second",
        f"{best:,.0f}, {best / arrays:.2f} of arrays",
    )
    assert best >= MIN_SHARE * arrays
