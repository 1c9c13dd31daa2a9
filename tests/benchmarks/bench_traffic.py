"""What stops the robots of a fleet: the table robot by robot, and the time of both forms."""

from collections.abc import Callable

import numpy as np
import pytest
from helpers.crowds import LINES, check_crowds
from helpers.timing import seconds

from warehouse_core import random_layout
from warehouse_core.motion.grid import GridMotion
from warehouse_core.motion.traffic import find_stops
from warehouse_core.world.actions import DISPLACEMENTS, WAIT
from warehouse_core.world.tiles import moved

MOVES = 2_000_000
FLOOR = {"height": 140, "width": 500, "density": 0.1, "seed": 1}
ROUNDS, MOVES_TIMED = 7, 20_000


def test_both_forms_follow_the_table(measured) -> None:
    lines = check_crowds(MOVES, seed=1)
    counts = ", ".join(f"{line} {lines[line]:,}" for line in LINES)
    measured("robot moves in crowds whose stops are those of the table", f"{counts}; 0 different")


@pytest.mark.parametrize("robots", [10, 100, 1_000, 10_000])
def test_nanoseconds_a_robot_move(robots: int, measured) -> None:
    """Random moves from random cells; the array form of the table, and of all that a step does."""
    layout, stream = random_layout(**FLOOR), np.random.default_rng(robots)
    starts = stream.permutation(layout.open_cells)[:robots]
    cells = [divmod(cell, layout.width) for cell in starts.tolist()]
    motion, batch = GridMotion(), GridMotion().fleet_batch([layout], robots)
    motion.reset(layout, cells, None)
    batch.place(np.arange(robots), starts)
    actions, loaded = stream.integers(0, WAIT + 1, robots), np.zeros(robots, np.bool_)
    moves = [DISPLACEMENTS[action] for action in actions.tolist()]
    targets = list(map(moved, cells, moves))
    walled = np.array([not layout.is_open(target) for target in targets])
    steps = np.array([row * layout.width + col for row, col in DISPLACEMENTS])
    goals = starts + np.where(walled, 0, steps[actions])
    calls: dict[str, Callable[[], object]] = {
        "find_stops": lambda: find_stops(layout, cells, targets),
        "by arrays": lambda: batch._traffic.find_stops(starts, goals, walled),
        "GridMotion.advance": lambda: motion.advance(moves, loaded),
        "GridFleetBatch.advance": lambda: batch.advance(actions, loaded),
    }
    repeats = max(1, MOVES_TIMED // robots)
    rounds = [
        {
            name: seconds(lambda call=call: [call() for _ in range(repeats)])
            for name, call in calls.items()
        }
        for _ in range(ROUNDS)
    ]
    best = {name: min(each[name] for each in rounds) / repeats / robots * 1e9 for name in calls}
    figure = ", ".join(f"{name} {nanoseconds:,.0f}" for name, nanoseconds in best.items())
    measured(f"nanoseconds a robot move, {robots:,} robots", figure)
