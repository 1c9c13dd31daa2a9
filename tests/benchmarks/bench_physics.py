"""Bodies compared with a bare ``space.step``, fleets of bodies, and long runs with exact results.

The environment variable ``TRUTH_MOVES`` sets the number of robot moves in long runs.
"""

import os
import random
import time
from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.fleet_truth import free_moves
from helpers.physics_truth import (
    differences_in_jams,
    errors_of_the_books,
    queue,
    random_robots_move_as_the_grid,
    straight_queue,
    winding_queue,
)
from helpers.rigid_bodies import batch_in

from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, WarehouseEnv, random_layout
from warehouse_core.world import benchmark_warehouse
from warehouse_physics import RigidBodyMotion, RobotSpec, stepping

MOVES = 2_000
"""Number of moves in a round of a measurement."""

BATCH_STEPS = 4
"""Minimum number of steps of a batch in a round; small batches take more, up to ``MOVES`` moves."""

MIN_RATIOS = {1: 0.35, 16: 1.6, 64: 3.0, 256: 3.0, 1024: 3.0}
"""Minimum ratio of moves per second in a batch and in one environment, by number of rows."""

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
    """Step an environment, and return the number of physics substeps that this took."""
    substeps = 0
    per_second = 1 / env.motion.spec.time_step
    for action in actions:
        env.step(action)
        substeps += round(env.last_motion.seconds * per_second)
    return substeps


def bare_loop(env: WarehouseEnv, substeps: int) -> None:
    """Step the same space ``substeps`` times without doing anything else."""
    step, dt = env.motion._arena.space.step, env.motion.spec.time_step
    for _ in range(substeps):
        step(dt)


@over_layouts
@pytest.mark.parametrize(("record_path", "least"), [(False, 0.8), (True, 0.65)])
def test_moves_a_second_against_the_bare_space(layout, record_path, least, times_faster) -> None:
    """The bare loop calls pymunk's public step, whose Python part our code skips.

    The target is a ratio of 0.8, and 0.7 with recorded paths.
    """
    env, actions = env_in(layout, record_path=record_path), random_moves()
    substeps = step_many(env, actions)
    ratio = times_faster(
        lambda: [env.step(action) for action in actions], lambda: bare_loop(env, substeps)
    )
    assert ratio >= least


@pytest.mark.parametrize(("rows", "least"), MIN_RATIOS.items())
def test_moves_a_second_of_a_batch_against_one_environment(rows, least, times_faster) -> None:
    """The target is a ratio of 4 with 256 rows."""
    steps = max(BATCH_STEPS, MOVES // rows)
    batch, env = batch_in([DEFAULT_LAYOUT] * rows), env_in(DEFAULT_LAYOUT)
    actions, empty = random_moves(steps * rows), np.zeros(rows, bool)
    moves = np.array(["NESW".index(action) for action in actions]).reshape(steps, rows)
    ratio = times_faster(
        lambda: [batch.advance(each, empty) for each in moves],
        lambda: [env.step(action) for action in actions],
    )
    assert ratio >= least


LARGE = benchmark_warehouse(6, 30, 8, 2, 2)
"""A layout of 124 x 90 cells."""

DRIVES, ROBOT_MOVES = 4, 3000
SUBSTEPS = 1 / RobotSpec().time_step
"""Number of substeps per second."""


class Drive:
    """Robots that carry out the same moves from the same cells in every run."""

    def __init__(self, robots: int, record_path: bool) -> None:
        stream = np.random.default_rng(robots)
        starts = stream.permutation(LARGE.open_cells)[:robots]
        self.robots, self.motion = robots, RigidBodyMotion(record_path=record_path)
        self.starts: list[Cell] = [divmod(cell, LARGE.width) for cell in starts.tolist()]
        self.plan: list[tuple[Sequence[Cell], Sequence[Cell]]] = []
        cells = self.starts
        for _ in range(max(3, ROBOT_MOVES // robots)):
            moves, cells = free_moves(LARGE, cells, stream)
            self.plan.append((moves, cells))

    def run(self) -> tuple[float, float, float]:
        """Return the simulated time, the wall-clock time and the CPU time, in seconds."""
        self.motion.reset(LARGE, self.starts, 0)
        simulated = wall = cpu = 0.0
        for moves, targets in self.plan:
            since, used = time.perf_counter(), time.process_time()
            outcomes = self.motion.advance(moves, [False] * self.robots)
            wall, cpu = wall + time.perf_counter() - since, cpu + time.process_time() - used
            assert [outcome.cell for outcome in outcomes] == targets
            simulated += max(outcome.seconds for outcome in outcomes)
        return simulated, wall, cpu


@pytest.mark.parametrize("record_path", [True, False])
def test_many_bodies_cost_little_more_each_than_ten(record_path: bool, measured) -> None:
    drives = [Drive(robots, record_path) for robots in (10, 100, 400, 1000)]
    rounds = [[drive.run() for drive in drives] for _ in range(DRIVES)]
    costs, words, speed = {}, [], (0.0, 0.0)
    for drive, found in zip(drives, zip(*rounds, strict=True), strict=True):
        simulated, wall, cpu = (min(column) for column in zip(*found, strict=True))
        costs[drive.robots] = cpu / (simulated * SUBSTEPS * drive.robots)
        unit = " bodies" if not words else ""
        words.append(f"{costs[drive.robots] * 1e6:.2f} µs for {drive.robots:,}{unit}")
        speed = simulated / wall, simulated / cpu
    paths = "with paths" if record_path else "without paths"
    measured(
        f"CPU time per body and substep, {paths}",
        f"{', '.join(words)}; ratio of 400 to 10: {costs[400] / costs[10]:.2f}",
    )
    measured(
        f"simulated seconds per second, 1,000 bodies {paths}",
        f"{speed[0]:.1f} in wall-clock time, {speed[1]:.1f} in CPU time",
    )
    assert speed[1] >= 5
    assert costs[400] <= 1.3 * costs[10]


TRUTH_MOVES = int(os.environ.get("TRUTH_MOVES", "60000"))
BOOKED = TRUTH_MOVES // 10
"""Number of moves whose energy is accounted for in every substep, by slow code."""


@pytest.fixture
def public_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let each substep call ``space.step``, which keeps the independent accounts."""
    monkeypatch.setattr(stepping, "IS_KNOWN", False)


def test_random_robots_move_as_on_the_grid_alone_and_in_a_batch(measured) -> None:
    made, braked = random_robots_move_as_the_grid(TRUTH_MOVES)
    measured(
        f"{made:,} moves of random robots, {braked:,} with robots that the floor alone brakes",
        "0 differences from the grid, and 0 between a batch and single robots",
    )


def test_heavy_jams_end_as_the_table_says(measured) -> None:
    made, wrong, cut_off = differences_in_jams(TRUTH_MOVES)
    measured(f"{made:,} robot moves in heavy jams", f"{wrong} differences, {cut_off} cut off")
    assert (wrong, cut_off) == (0, 0)


@pytest.mark.parametrize("make_queue", [straight_queue, winding_queue])
def test_queues_of_160_end_as_the_table_says(make_queue, measured) -> None:
    layout, cells = make_queue(160)
    for loaded in (False, True):
        outcomes = queue(layout, cells, loaded)
        wrong = sum(it.cell != cell for it, cell in zip(outcomes, cells, strict=True))
        seconds = max(outcome.seconds for outcome in outcomes)
        kind = make_queue.__name__.replace("_", " ")
        name = f"{kind} of 160 robots{' with loads' if loaded else ''}"
        measured(name, f"{wrong} differences, {seconds:.2f} s")
        assert wrong == 0
        assert not any(outcome.cut_off for outcome in outcomes)


@pytest.mark.usefixtures("public_steps")
@pytest.mark.parametrize("robots", [1, 8])
def test_the_books_agree_within_a_hundredth(robots: int, measured) -> None:
    errors = errors_of_the_books(BOOKED, robots, seed=1000)
    words = f"{_spread(errors.joules, 'energies')}; {_spread(errors.impulses, 'impulses')}"
    measured(f"comparison with independent accounts, {robots} random robots at a time", words)
    for each in errors:
        assert max(each, default=0.0) <= 0.01


def _spread(errors: Sequence[float], noun: str) -> str:
    above = Counter(error > 0.01 for error in errors)[True]
    worst = max(errors, default=0.0)
    return f"{len(errors)} {noun} differ by at most {100 * worst:.2g}%, {above} by more than 1%"
