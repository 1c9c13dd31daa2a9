"""The physics backend against a bare ``space.step``; ``bench_physics_truth.py`` has long runs."""

import random
from statistics import median
from time import perf_counter

import numpy as np
import pytest
from helpers.rigid_bodies import STEPS, batch_in, drive_at_walls

from warehouse_core import DEFAULT_LAYOUT, Layout, WarehouseEnv, random_layout
from warehouse_physics import Disturbances, RigidBodyMotion

MOVES = 2_000
"""In a round of a measurement."""

TUNNEL_MOVES = 100_000
FLEET = 200
RESETS = 20
BATCH_STEPS = 4
"""Actions of a whole batch in a round of a measurement, or more for as many ``MOVES``."""

MIN_RATIOS = {1: 0.35, 16: 1.6, 64: 3.0, 256: 3.0, 1024: 3.0}
"""Rows of a batch, and how many times more moves a second it must make than one environment."""

ENDLESS = 10**9

LAYOUTS = {"default": DEFAULT_LAYOUT, "100 x 100": random_layout(100, 100, 0.2, seed=1)}
over_layouts = pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS.keys())


def env_in(layout: Layout, *, record_path: bool = False) -> WarehouseEnv:
    backend = RigidBodyMotion(record_path=record_path)
    start = layout.open_cell(0)
    return WarehouseEnv(layout, start, max_steps=ENDLESS, battery=ENDLESS, backend=backend)


def random_moves(moves: int = MOVES) -> list[str]:
    return random.Random(0).choices("NESW", k=moves)


def step_many(env: WarehouseEnv, actions: list[str]) -> int:
    """Step, and return how many substeps of physics that took."""
    substeps = 0
    per_second = 1 / env.motion.spec.time_step
    for action in actions:
        env.step(action)
        substeps += round(env.last_motion.seconds * per_second)
    return substeps


def bare_loop(env: WarehouseEnv, substeps: int) -> None:
    """Step the same space ``substeps`` times, and do nothing else."""
    step, dt = env.motion._arena.space.step, env.motion.spec.time_step
    for _ in range(substeps):
        step(dt)


@over_layouts
def test_moves_a_second_against_the_bare_space(layout, times_faster) -> None:
    """The bare loop calls pymunk's public step, whose Python half is left out by ours."""
    env, actions = env_in(layout), random_moves()
    substeps = step_many(env, actions)
    ratio = times_faster(
        lambda: [env.step(action) for action in actions], lambda: bare_loop(env, substeps)
    )
    assert ratio >= 0.8


def test_a_large_fleet_against_the_bare_space(times_faster) -> None:
    layout, stream = random_layout(24, 24, 0.1, seed=2), random.Random(1)
    motion = RigidBodyMotion(record_path=False)
    ranks = stream.sample(range(len(layout.open_cells)), FLEET)
    motion.reset(layout, [layout.open_cell(rank) for rank in ranks], 0)
    substeps = 0

    def advance() -> None:
        nonlocal substeps
        moves, loaded = stream.choices(STEPS, k=FLEET), stream.choices([False, True], k=FLEET)
        seconds = max(outcome.seconds for outcome in motion.advance(moves, loaded))
        substeps = round(seconds / motion.spec.time_step)

    def bare() -> None:
        for _ in range(substeps):
            motion._arena.space.step(motion.spec.time_step)

    assert times_faster(advance, bare) >= 0.4


@pytest.mark.parametrize(
    "disturbances", [Disturbances(actuation_noise=0.1), Disturbances(motor_strength=0.6)]
)
def test_a_floor_that_is_the_same_everywhere_is_not_felt_in_each_substep(
    disturbances, times_faster
) -> None:
    rare, often = (RigidBodyMotion(disturbances=disturbances, record_path=False) for _ in range(2))
    for motion in (rare, often):
        motion.reset(DEFAULT_LAYOUT, [DEFAULT_LAYOUT.open_cell(0)], 0)
    often._arena._varies = True
    moves = random.Random(0).choices(STEPS, k=MOVES)
    ratio = times_faster(
        lambda: [rare.advance([move], [False]) for move in moves],
        lambda: [often.advance([move], [False]) for move in moves],
    )
    assert ratio >= 1.6


@over_layouts
def test_recording_paths_costs_at_most_a_third_more(layout, times_faster) -> None:
    kept, left_off = env_in(layout, record_path=True), env_in(layout)
    actions = random_moves()
    ratio = times_faster(lambda: step_many(kept, actions), lambda: step_many(left_off, actions))
    assert ratio >= 3 / 4


@pytest.mark.parametrize(
    ("layout", "milliseconds"), [(DEFAULT_LAYOUT, 1.0), (LAYOUTS["100 x 100"], 20.0)]
)
def test_a_reset_takes_no_longer_than_allowed(layout, milliseconds, benchmark, capsys) -> None:
    motion, start = RigidBodyMotion(), layout.open_cell(0)
    taken = []
    for _ in range(RESETS):
        begin = perf_counter()
        motion.reset(layout, [start], 0)
        taken.append(1000 * (perf_counter() - begin))
    with capsys.disabled():
        print(f"\nreset of {layout.height} x {layout.width}: {median(taken):.3g} ms")
    benchmark.pedantic(lambda: motion.reset(layout, [start], 0), rounds=1)
    assert median(taken) < milliseconds


@pytest.mark.parametrize("time_step", [1 / 60, 1 / 30])
def test_nothing_gets_through_a_wall_in_a_hundred_thousand_moves(time_step) -> None:
    drive_at_walls(time_step, TUNNEL_MOVES // 2)


@pytest.mark.parametrize(("rows", "least"), MIN_RATIOS.items())
def test_moves_a_second_of_a_batch_against_one_environment(rows, least, times_faster) -> None:
    """The target is 4 at 256 rows."""
    steps = max(BATCH_STEPS, MOVES // rows)
    batch, env = batch_in([DEFAULT_LAYOUT] * rows), env_in(DEFAULT_LAYOUT)
    actions, empty = random_moves(steps * rows), np.zeros(rows, bool)
    drawn = np.array(["NESW".index(action) for action in actions]).reshape(steps, rows)
    ratio = times_faster(
        lambda: [batch.advance(each, empty) for each in drawn],
        lambda: [env.step(action) for action in actions],
    )
    assert ratio >= least


def test_a_row_of_a_large_batch_costs_what_one_of_256_costs(times_faster) -> None:
    batches = [batch_in([DEFAULT_LAYOUT] * rows) for rows in (4096, 256)]
    drawn, empty = np.random.default_rng(0).integers(0, 4, 4096), np.zeros(4096, bool)
    large, small = batches
    ratio = times_faster(
        lambda: large.advance(drawn, empty),
        lambda: [small.advance(each, empty[:256]) for each in drawn.reshape(16, 256)],
    )
    assert ratio >= 1 / 1.2
