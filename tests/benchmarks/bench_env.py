"""One environment and batches: steps per second, import time and memory.

``STEPS_SHARE=0.1`` runs a tenth of the steps in long runs.
"""

import os
import random
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from helpers.timing import resident

from warehouse_core import DEFAULT_LAYOUT, BatchEnv, Layout, WarehouseEnv
from warehouse_core.gymnasium_env import ID

STEPS = 100_000


def step_many(env: Any, actions: list[Any], *reset: bool) -> None:
    for action in actions:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset(*reset)


def random_actions() -> list[str]:
    return random.Random(0).choices(WarehouseEnv.ACTIONS, k=STEPS)


def test_a_step_beats_frozen_lake(times_faster):
    env, lake = WarehouseEnv(), gymnasium.make("FrozenLake-v1").unwrapped
    actions, lake_actions = random_actions(), random.Random(0).choices(range(4), k=STEPS)
    env.reset()
    lake.reset(seed=0)
    ours = times_faster(lambda: step_many(env, actions), lambda: step_many(lake, lake_actions))
    assert ours >= 3.5


GYM_STEPS = 30_000
BATCH, BATCH_STEPS = 4096, 25
WARM_UP = 250
EPISODE, WAIT = 200, 4


def stepping(env: Any, steps: int, actions: int) -> Callable[[], None]:
    """Return a function that takes random steps and resets episodes that end."""
    chosen = random.Random(0).choices(range(actions), k=steps)
    env.reset()

    def work() -> None:
        step, reset = env.step, env.reset
        for action in chosen:
            _, _, terminated, truncated, _ = step(action)
            if terminated or truncated:
                reset()

    return work


def stepping_all(env: Any, actions: int, steps: int = BATCH_STEPS) -> Callable[[], None]:
    """Return a function that takes random steps of a batch, after ``WARM_UP`` other steps."""
    stream = np.random.default_rng(0)
    for _ in range(WARM_UP):
        env.step(stream.integers(actions, size=env.num_envs))
    chosen = stream.integers(actions, size=(steps, env.num_envs))

    def work() -> None:
        for each in chosen:
            env.step(each)

    return work


def warehouses(count: int, layout: Layout = DEFAULT_LAYOUT, **settings: Any) -> Any:
    """Return a batch in which some episodes end and others start in every step."""
    env = gymnasium.make_vec(ID, count, "vector_entry_point", layout=layout, **settings)
    env.reset(seed=0)
    for step in range(EPISODE):
        env.step(np.full(count, WAIT))
        mask = np.arange(count) % EPISODE == step
        env.reset(options={"reset_mask": mask})
    return env


def carts(count: int) -> Any:
    """Return a batch of CartPole, whose episodes are short and end in different steps."""
    env = gymnasium.make_vec("CartPole-v1", count, "vector_entry_point")
    env.reset(seed=0)
    return env


def test_a_step_keeps_up_with_frozen_lake(times_faster) -> None:
    ours = stepping(gymnasium.make(ID).unwrapped, GYM_STEPS, 7)
    lake = stepping(gymnasium.make("FrozenLake-v1").unwrapped, GYM_STEPS, 4)
    assert times_faster(ours, lake) >= 1.0


@pytest.mark.parametrize(("view_radius", "share"), [(2, 0.4), (0, 0.8)])
def test_a_batch_against_gymnasiums_fastest(view_radius, share, times_faster) -> None:
    """A batch of CartPole does only a few operations on an array with four numbers per row."""
    ours = stepping_all(warehouses(BATCH, view_radius=view_radius), 7)
    assert times_faster(ours, stepping_all(carts(BATCH), 2)) >= share


@pytest.mark.parametrize("view_radius", [0, 2])
@pytest.mark.parametrize("count", [4_096, 16_384, 65_536])
def test_a_row_costs_no_more_in_a_larger_batch(count, view_radius, times_faster) -> None:
    """Batches of ``count`` rows and of 1,024 rows take the same number of steps in total."""
    few = 1_024
    ours, theirs = (warehouses(rows, view_radius=view_radius) for rows in (count, few))
    works = stepping_all(ours, 7, steps=5), stepping_all(theirs, 7, steps=5 * count // few)
    assert times_faster(*works) >= 1 / 1.1


SHARE = float(os.environ.get("STEPS_SHARE", "1"))
TENTHS = 10
MAX_GROWTH = 8 * 2**20
"""Maximum growth in bytes from the second tenth, when all caches are filled, to the last."""


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
        f"memory during {round(steps * SHARE):,} steps, {name}",
        f"{sizes[1] / 2**20:.1f} MB after 20% of the steps, {sizes[-1] / 2**20:.1f} MB at the end",
    )
    assert sizes[-1] - sizes[1] <= MAX_GROWTH
