"""Steps with malformed actions, and the memory of very many steps.

``STEPS_SHARE=0.1`` takes a tenth of all steps.
"""

import os
from collections.abc import Callable

import numpy as np
import pytest
from helpers.malformed import MAKERS, step_malformed
from helpers.timing import resident

from warehouse_core import BatchEnv, WarehouseEnv

SHARE = float(os.environ.get("STEPS_SHARE", "1"))
TENTHS = 10
MAX_GROWTH = 8 * 2**20
"""Bytes between the second tenth, when all caches are filled, and the last."""


@pytest.mark.parametrize(
    ("name", "steps"),
    [("WarehouseEnv", 4_000_000), ("BatchEnv", 2_000_000), ("Warehouse-v0", 4_000_000)],
)
def test_malformed_actions_raise_only_documented_errors(
    name: str, steps: int, measured: Callable[[str, object], None]
) -> None:
    assert name in MAKERS
    tally = step_malformed(name, round(steps * SHARE), seed=1)
    measured(
        f"malformed actions, {name}",
        f"{tally.steps:,}: {tally.refused:,} refused with documented errors, {tally.taken:,} taken "
        f"as invalid; state compared {tally.compared:,} times, 0 changes",
    )


def in_batch(steps: int) -> None:
    env, stream = BatchEnv(1000), np.random.default_rng(0)
    env.reset(seed=1)
    actions = stream.integers(0, 7, (100, 1000))
    for number in range(steps // 1000):
        env.step(actions[number % 100])
    env.close()


def alone(steps: int, backend: str) -> None:
    env, stream = WarehouseEnv(backend=backend), np.random.default_rng(0)
    actions = stream.integers(0, 7, 1000).tolist()
    env.reset(seed=1)
    for number in range(steps):
        if any(env.step(actions[number % 1000])[2:4]):
            env.reset(randomize=True, seed=number)
    env.close()


@pytest.mark.parametrize(
    ("name", "steps", "work"),
    [
        ("BatchEnv", 200_000_000, in_batch),
        ("grid", 1_000_000, lambda steps: alone(steps, "grid")),
        ("physics", 100_000, lambda steps: alone(steps, "physics")),
    ],
)
def test_memory_does_not_grow(name, steps, work, measured) -> None:
    sizes = []
    for _ in range(TENTHS):
        work(round(steps * SHARE / TENTHS))
        sizes.append(resident())
    measured(
        f"memory of {round(steps * SHARE):,} steps, {name}",
        f"{sizes[1] / 2**20:.1f} MB after two tenths, {sizes[-1] / 2**20:.1f} MB at the end",
    )
    assert sizes[-1] - sizes[1] <= MAX_GROWTH
