"""Random moves of rigid bodies, alone, in fleets and in batches, compared with the grid."""

import math
import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from warehouse_core import Cell, Layout, Outcome, WarehouseEnv, random_layout
from warehouse_core.motion.base import BatchOutcome, centre_of
from warehouse_core.world.actions import DISPLACEMENTS
from warehouse_core.world.tiles import moved
from warehouse_physics import RigidBodyMotion, RobotSpec
from warehouse_physics.batch.rigid_body_batch import RigidBodyBatch
from warehouse_physics.rigid_body_motion import PATH_EVERY

LEDGE = Layout(["."])
"""One cell, so that every move ends at a wall."""

STAY, NORTH, EAST, SOUTH, WEST = STEPS = ((0, 0), (-1, 0), (0, 1), (1, 0), (0, -1))
MOVES = (NORTH, EAST, SOUTH, WEST)


def motion_in(
    layout: Layout, cell: Cell, spec: RobotSpec | None = None, path_every: int = PATH_EVERY
) -> RigidBodyMotion:
    motion = RigidBodyMotion(spec, path_every=path_every)
    motion.reset(layout, [cell], 0)
    return motion


def together(
    layout: Layout,
    cells: Sequence[Cell],
    moves: Sequence[Cell],
    spec: RobotSpec | None = None,
    loaded: Sequence[bool] | None = None,
    **options: Any,
) -> list[Outcome]:
    """Let robots make one move each; by default none carries an item."""
    motion = RigidBodyMotion(spec, **options)
    motion.reset(layout, cells, 0)
    return list(motion.advance(moves, loaded or [False] * len(cells)))


def move(motion: RigidBodyMotion, displacement: Cell, loaded: bool = False) -> Outcome:
    return motion.advance([displacement], [loaded])[0]


def drive_at_walls(time_step: float, moves: int) -> None:
    """Drive at walls at the highest speed; a body may enter them by at most one substep."""
    radius = 0.35
    top_speed = radius / 2 / time_step
    spec = RobotSpec(
        radius=radius, top_speed=top_speed, acceleration=1e6, motor_force=1e9, time_step=time_step
    )
    motion, stream = motion_in(LEDGE, (0, 0), spec, path_every=1), random.Random(0)
    for _ in range(moves):
        outcome = move(motion, stream.choice(MOVES), stream.random() < 0.5)
        assert (outcome.cell, outcome.blocked) == ((0, 0), True)
        depth = np.abs(outcome.path[:, 1:3] - 0.5).max() + radius - 0.5
        assert depth <= top_speed * time_step


def some_layouts(count: int, stream: random.Random) -> list[Layout]:
    """Return layouts of different sizes, and the first of them again as the last."""
    sizes = [(stream.randint(4, 12), stream.randint(4, 12)) for _ in range(count - 1)]
    layouts = [random_layout(*size, 0.25, seed=seed) for seed, size in enumerate(sizes)]
    return [*layouts, layouts[0]]


def batch_in(layouts: Sequence[Layout], spec: RobotSpec | None = None) -> RigidBodyBatch:
    """Return a batch with each robot in the first open cell of its layout."""
    batch = RigidBodyMotion(spec).batch(layouts)
    batch.place(np.arange(len(layouts)), np.array([each.open_cells[0] for each in layouts]))
    return batch


class Singles:
    """A single motion for each row, compared with the grid."""

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout]) -> None:
        self.layouts, self._size = layouts, spec.cell_size
        self.motions = [RigidBodyMotion(spec, record_path=False) for _ in layouts]
        self._cells: list[Cell] = [(0, 0)] * len(layouts)

    def place(self, row: int, cell: int) -> None:
        self._cells[row] = self.layouts[row].cell(cell)
        self.motions[row].reset(self.layouts[row], [self._cells[row]], 0)

    def advance(self, actions: Sequence[int], loaded: Sequence[bool]) -> BatchOutcome:
        """Move all robots; each ends in the middle of the same cell as on the grid."""
        numbers, others = [], []
        for row, (layout, motion) in enumerate(zip(self.layouts, self.motions, strict=True)):
            move, home = DISPLACEMENTS[actions[row]], self._cells[row]
            is_open = layout.is_open(moved(home, move))
            self._cells[row] = end = moved(home, move) if is_open else home
            outcome = motion.advance([move], [loaded[row]])[0]
            assert outcome[:2] == (end, not is_open)
            middle = centre_of(end, self._size)
            assert math.dist(outcome.path[-1, 1:3], middle) <= 1.001e-3 * self._size
            numbers.append(layout.number(end))
            others.append((outcome.blocked, outcome.seconds, outcome.joules))
        return BatchOutcome(*map(np.array, (numbers, *zip(*others, strict=True))))


def rows_differ(spec: RobotSpec, rows: int, steps: int, seed: int = 0, joules: float = 1e-6) -> int:
    """Drive a batch and single motions, compare them, and return the number of blocked moves.

    Single rows are placed again between the moves, and loads change at random. Nothing may differ,
    except the energy by a share of ``joules``.
    """
    stream, blocked = random.Random(seed), 0
    layouts = some_layouts(rows, stream)
    batch, singles = batch_in(layouts, spec), Singles(spec, layouts)
    for row, layout in enumerate(layouts):
        singles.place(row, int(layout.open_cells[0]))
    loaded = [False] * rows
    for step in range(steps):
        placed = [row for row in range(rows) if stream.random() < 0.05]
        cells = [int(stream.choice(layouts[row].open_cells)) for row in placed]
        batch.place(np.array(placed, int), np.array(cells, int))
        for row, cell in zip(placed, cells, strict=True):
            singles.place(row, cell)
        loaded = [load != (stream.random() < 0.2) for load in loaded]
        actions = stream.choices(range(8), [3, 3, 3, 3, 1, 1, 1, 1], k=rows)
        outcome = batch.advance(np.array(actions), np.array(loaded))
        expected = singles.advance(actions, loaded)
        for name in ("cells", "blocked"):
            assert getattr(outcome, name).tolist() == getattr(expected, name).tolist(), (name, step)
        assert outcome.seconds == pytest.approx(expected.seconds, rel=1e-9), step
        assert outcome.joules == pytest.approx(expected.joules, rel=joules), step
        blocked += int(outcome.blocked.sum())
    return blocked


LAYOUTS = 20

ACTIONS = (*WarehouseEnv.ACTIONS, *"NESW" * 3, 0, 1, 2, 3, 99, "fly")


def steps_differ(spec: RobotSpec, moves: int, layouts: int = LAYOUTS) -> int:
    """Step both backends, compare them, and return the number of blocked steps."""
    stream, blocked = random.Random(0), 0
    for seed in range(layouts):
        layout = random_layout(stream.randint(4, 12), stream.randint(4, 12), 0.25, seed=seed)
        limits = {"start_pos": layout.open_cell(0), "max_steps": 200, "battery": 190}
        grid = WarehouseEnv(layout, **limits)
        physics = WarehouseEnv(layout, **limits, backend=RigidBodyMotion(spec, record_path=False))
        for number in range(moves // layouts):
            if number % 150 == 0:
                randomize = number % 300 == 0
                expected = grid.reset(randomize, seed=number)
                assert physics.reset(randomize, seed=number) == expected
            action = stream.choice(ACTIONS)
            assert physics.step(action) == grid.step(action), (layout.rows, number, action)
            assert physics.last_motion.blocked == grid.last_motion.blocked
            blocked += grid.last_motion.blocked
            # An item changes the physics, so let the robot carry one half of the time.
            if number % 20 == 0:
                grid.state.has_item = physics.state.has_item = not grid.state.has_item
        assert physics.render() == grid.render()
    return blocked
