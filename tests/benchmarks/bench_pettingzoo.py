"""Fleets as dictionaries of PettingZoo, beside their arrays and plain dictionaries."""

from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np
import pytest

from warehouse_core.pettingzoo_env import parallel_env
from warehouse_core.world.generators import shelf_layout

LAYOUT = shelf_layout(68, 99, 4)
"""139 x 498 cells."""

ROBOT_STEPS, ROUNDS = 40_000, 5
MIN_SHARE = 0.6
"""Of the rate at which rows of the arrays are put into dictionaries one by one."""


@pytest.mark.parametrize("robots", [4, 1_000])
def test_robots_as_dictionaries(robots: int, measured) -> None:
    """In a second of processor time, with orders, views of 5 x 5 and masks."""
    env = parallel_env(LAYOUT, robots, 10**6, battery=10**6, orders=20.0 / 10**3)
    env.reset(seed=0)
    stream = np.random.default_rng(0)
    chosen = stream.integers(7, size=(ROBOT_STEPS // robots, robots))
    joint = [dict(zip(env.agents, actions, strict=True)) for actions in chosen.tolist()]

    def plainly(actions: np.ndarray) -> list[dict[str, Any]]:
        arrays = env.fleet.step(actions)[0]
        return [{key: values[row] for key, values in arrays.items()} for row in range(robots)]  # type: ignore[index]

    def rate(step: Callable[[Any], object], actions: Any) -> float:
        start = process_time()
        for each in actions:
            step(each)
        return ROBOT_STEPS / (process_time() - start)

    ways = [(env.step, joint), (env.fleet.step, chosen), (plainly, chosen)]
    rates = [[rate(*way) for way in ways] for _ in range(ROUNDS + 1)][1:]
    best, arrays, plain = map(max, zip(*rates, strict=True))
    measured(
        f"PettingZoo dicts, {robots:,} robots on 139 x 498, robot-steps a second",
        f"{best:,.0f}, {best / arrays:.2f} of arrays, {best / plain:.2f} of plain dictionaries",
    )
    assert best >= MIN_SHARE * plain
