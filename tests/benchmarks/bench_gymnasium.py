"""``Warehouse-v0``, one and thousands, against environments of Gymnasium and MiniGrid."""

import random
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

from warehouse_core import DEFAULT_LAYOUT, Layout, WarehouseEnv
from warehouse_core.gymnasium_env import ID

STEPS, PHYSICS_STEPS, FRAMES = 30_000, 3_000, 200
BATCH, BATCH_STEPS = 4096, 25
WARM_UP = 250
MAX_STEPS, WAIT = 200, 4

ENDLESS = 10**9


def hall(side: int) -> Layout:
    """Return a square of open floor with a wall around it."""
    inside = ["#" + "." * (side - 2) + "#"] * (side - 2)
    return Layout(["#" * side, *inside, "#" * side])


def stepping(env: Any, steps: int, actions: int) -> Callable[[], None]:
    """Return the work of so many random steps; episodes that end are reset."""
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
    """Return the work of so many random steps of a batch, after ``WARM_UP`` others."""
    stream = np.random.default_rng(0)
    for _ in range(WARM_UP):
        env.step(stream.integers(actions, size=env.num_envs))
    chosen = stream.integers(actions, size=(steps, env.num_envs))

    def work() -> None:
        for each in chosen:
            env.step(each)

    return work


def warehouses(count: int, layout: Layout = DEFAULT_LAYOUT, **settings: Any) -> Any:
    """Return a batch in which some episodes end and some start at every step."""
    env = gymnasium.make_vec(ID, count, "vector_entry_point", layout=layout, **settings)
    env.reset(seed=0)
    for step in range(MAX_STEPS):
        env.step(np.full(count, WAIT))
        mask = np.arange(count) % MAX_STEPS == step
        env.reset(options={"reset_mask": mask})
    return env


def carts(count: int) -> Any:
    """Return the batch of CartPole, whose episodes are short and end at different steps."""
    env = gymnasium.make_vec("CartPole-v1", count, "vector_entry_point")
    env.reset(seed=0)
    return env


def test_a_step_keeps_up_with_frozen_lake(times_faster) -> None:
    ours = stepping(gymnasium.make(ID).unwrapped, STEPS, 7)
    lake = stepping(gymnasium.make("FrozenLake-v1").unwrapped, STEPS, 4)
    assert times_faster(ours, lake) >= 1.0


def test_a_picture_is_painted_three_times_as_fast_as_a_minigrid(times_faster) -> None:
    import minigrid  # noqa: F401 - registers its environments

    def filming(name: str) -> Callable[[], None]:
        env = gymnasium.make(name, render_mode="rgb_array").unwrapped
        env.reset(seed=0)
        assert min(env.render().shape[:2]) >= 256

        def work() -> None:
            for number in range(FRAMES):
                env.step(number % 3)
                env.render()
            env.reset()

        return work

    assert times_faster(filming(ID), filming("MiniGrid-Empty-8x8-v0")) >= 3.0


@pytest.mark.parametrize(("view_radius", "share"), [(2, 0.4), (0, 0.8)])
def test_a_batch_against_gymnasiums_fastest(view_radius, share, times_faster) -> None:
    """CartPole's batch is a few operations on one array of four numbers a row."""
    ours = stepping_all(warehouses(BATCH, view_radius=view_radius), 7)
    assert times_faster(ours, stepping_all(carts(BATCH), 2)) >= share


@pytest.mark.parametrize("view_radius", [2, 0])
def test_vectors_take_little_longer_than_dicts(view_radius, times_faster) -> None:
    """A vector has 86 float32 for each row, a dict 65 bytes."""
    forms = (
        warehouses(BATCH, observation=form, view_radius=view_radius) for form in ("vector", "dict")
    )
    ours, dicts = (stepping_all(env, 7) for env in forms)
    assert times_faster(ours, dicts) >= 0.4


def test_a_reset_in_the_same_step_costs_little_more(times_faster) -> None:
    """Final observations are made only for rows that have ended, 20 of 4,096 in a step."""
    modes = ("SameStep", "NextStep")
    ours, usual = (stepping_all(warehouses(BATCH, autoreset_mode=mode), 7) for mode in modes)
    assert times_faster(ours, usual) >= 0.5


@pytest.mark.parametrize("view_radius", [0, 2])
@pytest.mark.parametrize("count", [4_096, 16_384, 65_536])
def test_a_row_costs_no_more_where_there_are_more(count, view_radius, times_faster) -> None:
    """Both take as many steps in total, in a batch of ``count`` rows and in one of 1,024."""
    few = 1_024
    ours, theirs = (warehouses(rows, view_radius=view_radius) for rows in (count, few))
    works = stepping_all(ours, 7, steps=5), stepping_all(theirs, 7, steps=5 * count // few)
    assert times_faster(*works) >= 1 / 1.1


@pytest.mark.parametrize(("side", "share"), [(100, 0.8), (1_000, 0.4)])
def test_a_larger_map_is_slower_only_because_of_the_caches(side, share, times_faster) -> None:
    """The same number of values is read, but no cache holds the tables of a million cells."""
    ours, usual = (
        stepping_all(warehouses(BATCH, each), 7) for each in (hall(side), DEFAULT_LAYOUT)
    )
    assert times_faster(ours, usual) >= share


def test_gymnasium_adds_little_to_a_step_of_the_physics(times_faster) -> None:
    limits = {"max_steps": ENDLESS, "battery": ENDLESS, "backend": "physics"}
    ours = stepping(gymnasium.make(ID, randomize=False, **limits).unwrapped, PHYSICS_STEPS, 7)
    plain = stepping(WarehouseEnv(**limits), PHYSICS_STEPS, 7)
    assert times_faster(ours, plain) >= 1 / 1.15
