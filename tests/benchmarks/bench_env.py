"""Steps a second of one environment, and the cost of importing the core."""

import random
import subprocess
import sys

import gymnasium
import pytest

from warehouse_core import Layout, WarehouseEnv

STEPS = 100_000


def step_many(env: WarehouseEnv, actions: list[str], *, randomize: bool) -> None:
    for action in actions:
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            env.reset(randomize)


def random_actions() -> list[str]:
    return random.Random(0).choices(WarehouseEnv.ACTIONS, k=STEPS)


def big_grid() -> list[str]:
    """A hall of 100 x 100 with a pickup and a dropoff."""
    inside = ["#" + "." * 98 + "#"] * 96
    return ["#" * 100, "#P" + "." * 97 + "#", *inside, "#" + "." * 97 + "D#", "#" * 100]


def test_a_step_beats_frozen_lake(times_faster):
    env, lake = WarehouseEnv(), gymnasium.make("FrozenLake-v1").unwrapped
    actions, lake_actions = random_actions(), random.Random(0).choices(range(4), k=STEPS)
    env.reset()
    lake.reset(seed=0)

    def step_lake() -> None:
        for action in lake_actions:
            _, _, terminated, truncated, _ = lake.step(action)
            if terminated or truncated:
                lake.reset()

    assert times_faster(lambda: step_many(env, actions, randomize=False), step_lake) >= 3.5


def test_a_hundred_by_hundred_grid_is_about_as_fast(times_faster):
    small, big, actions = WarehouseEnv(), WarehouseEnv(big_grid()), random_actions()
    ratio = times_faster(
        lambda: step_many(big, actions, randomize=False),
        lambda: step_many(small, actions, randomize=False),
    )
    assert ratio >= 0.8


def test_a_hundred_by_hundred_grid_with_random_starts(times_faster):
    """Each episode has new stations and cells, which no cache holds."""
    small, big, actions = WarehouseEnv(), WarehouseEnv(big_grid()), random_actions()
    for _ in range(6):
        step_many(big, actions, randomize=True)
    ratio = times_faster(
        lambda: step_many(big, actions, randomize=True),
        lambda: step_many(small, actions, randomize=True),
    )
    # There is no target for this; below half, something is computed at every step.
    assert ratio >= 0.5


@pytest.mark.parametrize("view_radius", [2, 10])
def test_a_walk_into_new_cells_of_a_hundred_by_hundred_grid(view_radius, times_faster):
    """Row by row, each cell once, in a new layout each time; its reset counts too."""
    limits = {"max_steps": STEPS, "battery": STEPS, "view_radius": view_radius}
    small, big = WarehouseEnv(**limits), WarehouseEnv(big_grid(), **limits)
    there_and_back = [*"E" * 97, "S", *"W" * 97, "S"] * 46

    def walk() -> None:
        big.reset_to(Layout(big_grid()))
        step_many(big, there_and_back, randomize=False)

    actions = random_actions()[: len(there_and_back)]
    # Each new cell has a new path, which takes longer than the whole of a step in a known cell.
    assert times_faster(walk, lambda: step_many(small, actions, randomize=False), rounds=21) >= 0.35


def test_importing_the_core_costs_little_beyond_numpy(times_faster, capsys):
    def run(statement: str) -> None:
        subprocess.run([sys.executable, "-c", statement], check=True)

    ratio = times_faster(lambda: run("import warehouse_core"), lambda: run("import numpy"))
    # NumPy takes 0.06 to 0.15 s in a new interpreter, so the core adds 0.15 s at most.
    assert ratio >= 0.5
