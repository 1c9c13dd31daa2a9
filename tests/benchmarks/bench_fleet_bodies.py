"""Fleets of bodies: simulated time over time taken, and the cost of a robot in a substep.

The moves are those that planners send: nothing stops them. Each figure is the best of several
rounds, by the clock and by the time of the processor.
"""

import time
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.fleet_truth import free_moves

from warehouse_core import Cell
from warehouse_core.world import benchmark_warehouse
from warehouse_physics import RigidBodyMotion, RobotSpec

LAYOUT = benchmark_warehouse(6, 30, 8, 2, 2)
"""124 x 90 cells."""

ROUNDS, ROBOT_MOVES = 4, 3000
SUBSTEPS = 1 / RobotSpec().time_step
"""In a second."""


class Drive:
    """Robots that carry out the same moves again and again, from the same cells."""

    def __init__(self, robots: int, record_path: bool) -> None:
        stream = np.random.default_rng(robots)
        starts = stream.permutation(LAYOUT.open_cells)[:robots]
        self.robots, self.motion = robots, RigidBodyMotion(record_path=record_path)
        self.starts: list[Cell] = [divmod(cell, LAYOUT.width) for cell in starts.tolist()]
        self.plan: list[tuple[Sequence[Cell], Sequence[Cell]]] = []
        cells = self.starts
        for _ in range(max(3, ROBOT_MOVES // robots)):
            moves, cells = free_moves(LAYOUT, cells, stream)
            self.plan.append((moves, cells))

    def run(self) -> tuple[float, float, float]:
        """Return simulated seconds, those taken by the clock, and of the processor."""
        self.motion.reset(LAYOUT, self.starts, 0)
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
    rounds = [[drive.run() for drive in drives] for _ in range(ROUNDS)]
    costs, words, speed = {}, [], (0.0, 0.0)
    for drive, found in zip(drives, zip(*rounds, strict=True), strict=True):
        simulated, wall, cpu = (min(column) for column in zip(*found, strict=True))
        costs[drive.robots] = cpu / (simulated * SUBSTEPS * drive.robots)
        words.append(f"{costs[drive.robots] * 1e6:.2f} µs for {drive.robots:,}")
        speed = simulated / wall, simulated / cpu
    paths = "with paths" if record_path else "without paths"
    measured(
        f"CPU time of a body in a substep, {paths}",
        f"{', '.join(words)}; 400 to 10: {costs[400] / costs[10]:.2f}",
    )
    measured(
        f"simulated time over time taken, 1,000 bodies {paths}",
        f"{speed[0]:.1f} by the clock, {speed[1]:.1f} by CPU time",
    )
    assert speed[1] >= 5
    assert costs[400] <= 1.3 * costs[10]
