"""Random moves of rigid bodies, alone, in fleets and in batches, compared with the grid."""

import random
from collections.abc import Sequence

import numpy as np
import pytest

from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, Outcome, WarehouseEnv, random_layout
from warehouse_core.motion.batch import BatchOutcome
from warehouse_core.motion.traffic import find_stops
from warehouse_core.world.actions import DISPLACEMENTS
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


def move(motion: RigidBodyMotion, displacement: Cell, loaded: bool = False) -> Outcome:
    return motion.advance([displacement], [loaded])[0]


def drive_at_walls(time_step: float, moves: int) -> None:
    """Drive at walls at the highest speed that a robot may have.

    Raises:
        AssertionError: it passed through one, or went deeper into it than a substep's distance.
    """
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
    drawn = [random_layout(*size, 0.25, seed=seed) for seed, size in enumerate(sizes)]
    return [*drawn, drawn[0]]


def batch_in(layouts: Sequence[Layout], spec: RobotSpec | None = None) -> RigidBodyBatch:
    """Return a batch with each robot in the first open cell of its layout."""
    batch = RigidBodyMotion(spec).batch(layouts)
    batch.place(np.arange(len(layouts)), np.array([each.open_cells[0] for each in layouts]))
    return batch


class Singles:
    """A single motion for each row, for comparison."""

    def __init__(self, spec: RobotSpec, layouts: Sequence[Layout]) -> None:
        self.layouts = layouts
        self.motions = [RigidBodyMotion(spec, record_path=False) for _ in layouts]

    def place(self, row: int, cell: int) -> None:
        layout = self.layouts[row]
        self.motions[row].reset(layout, [divmod(cell, layout.width)], 0)

    def advance(self, actions: Sequence[int], loaded: Sequence[bool]) -> BatchOutcome:
        moves = zip(self.motions, actions, loaded, strict=True)
        each = [motion.advance([DISPLACEMENTS[move]], [load])[0] for motion, move, load in moves]
        cells = [
            outcome.cell[0] * layout.width + outcome.cell[1]
            for outcome, layout in zip(each, self.layouts, strict=True)
        ]
        others = [(outcome.blocked, outcome.seconds, outcome.joules) for outcome in each]
        return BatchOutcome(*map(np.array, (cells, *zip(*others, strict=True))))


def rows_differ(spec: RobotSpec, rows: int, steps: int, seed: int = 0) -> int:
    """Drive a batch and single motions side by side and return how many moves were blocked.

    Single rows are placed again between the moves, and loads change at random.

    Raises:
        AssertionError: something differs.
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
        for name in ("seconds", "joules"):
            ours, theirs = getattr(outcome, name), getattr(expected, name)
            assert ours == pytest.approx(theirs, rel=1e-6), (name, step)
        blocked += int(outcome.blocked.sum())
    return blocked


def targets_of(cells: list[Cell], moves: list[Cell]) -> list[Cell]:
    return [
        (row + down, col + right) for (row, col), (down, right) in zip(cells, moves, strict=True)
    ]


def fleet_keeps_the_table(
    spec: RobotSpec, robots: int, seed: int, actions: int, size: tuple[int, int] = (6, 8)
) -> None:
    """Move a fleet at random in a hall, half of it loaded; seed 0 is the chapter's layout.

    Raises:
        AssertionError: a robot ended in another cell than ``find_stops`` says.
    """
    stream = random.Random(100 * seed + robots)
    layout = random_layout(*size, 0.15, seed=seed) if seed else DEFAULT_LAYOUT
    cells = [layout.open_cell(i) for i in stream.sample(range(len(layout.open_cells)), robots)]
    motion = RigidBodyMotion(spec, record_path=False)
    motion.reset(layout, cells, 0)
    for _ in range(actions):
        moves = stream.choices(STEPS, k=robots)
        loaded = [stream.random() < 0.5 for _ in cells]
        targets = targets_of(cells, moves)
        stops = find_stops(layout, cells, targets)
        outcomes = motion.advance(moves, loaded)
        assert [outcome.blocked for outcome in outcomes] == [stop is not None for stop in stops]
        cells = [
            target if stop is None else cell
            for cell, target, stop in zip(cells, targets, stops, strict=True)
        ]
        assert [outcome.cell for outcome in outcomes] == cells
        assert len(set(cells)) == robots


LAYOUTS = 20

ACTIONS = (*WarehouseEnv.ACTIONS, *"NESW" * 3, 0, 1, 2, 3, 99, "fly")


def steps_differ(spec: RobotSpec, moves: int, layouts: int = LAYOUTS) -> int:
    """Step both backends side by side and return how many steps were blocked.

    Raises:
        AssertionError: one of the five values differs.
    """
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
            # A load changes the physics, so let the robot carry something half of the time.
            if number % 20 == 0:
                grid.state.has_item = physics.state.has_item = not grid.state.has_item
        assert physics.render() == grid.render()
    return blocked
