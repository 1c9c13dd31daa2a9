import numpy as np
import pytest

from warehouse_core import Layout, random_layout
from warehouse_core.motion.grid import GridBatch, GridMotion, nominal_joules
from warehouse_core.world.actions import DISPLACEMENTS

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

OPEN = Layout(["..", "..", ".."])
MOVING, STANDING = (nominal_joules(0.5, moving=moving) for moving in (True, False))
LAYOUTS = [OPEN, random_layout(5, 7, 0.3, seed=1), Layout([".#."]), OPEN, Layout(["."])]


def batch_of(layouts: list[Layout]) -> GridBatch:
    return GridMotion(0.5).batch(layouts)


def test_the_arrays_of_an_outcome_belong_to_the_caller() -> None:
    batch = batch_of([OPEN] * 2)
    batch.place(np.arange(2), np.array([0, 1]))
    actions, loaded = np.array([SOUTH, SOUTH]), np.zeros(2, bool)
    for array in batch.advance(actions, loaded)[:4]:
        array[:] = 1
    found = batch.advance(actions, loaded)
    assert found.cells.tolist() == [4, 5]
    assert found.seconds.tolist() == [1.0, 1.0]
    assert found.joules.tolist() == [MOVING, MOVING]
    assert found.blocked.tolist() == [False, False]
    batch.close()
    batch.close()
    with pytest.raises(RuntimeError, match="after close"):
        batch.advance(actions, loaded)


@pytest.mark.parametrize(("floors", "robots"), [(3, 1), (3, 6), (1, 6), (1, 12)])
def test_the_outcomes_of_a_floor_are_those_of_the_single_motion(floors: int, robots: int) -> None:
    """Paths, headings and contacts too, and of floors that were placed anew."""
    layouts = [random_layout(5, 7, 0.2, seed=seed) for seed in (1, 2, 1)[:floors]]
    stream = np.random.default_rng(0)
    batch = GridMotion(0.5).fleet_batch(layouts, robots)
    motions = [GridMotion(0.5) for _ in layouts]
    for step in range(60):
        for floor in range(floors) if step == 0 else stream.permutation(floors)[: step % 3]:
            cells = stream.permutation(layouts[floor].open_cells)[:robots]
            batch.place(np.arange(robots) + floor * robots, cells)
            starts = [divmod(int(cell), layouts[floor].width) for cell in cells]
            motions[floor].reset(layouts[floor], starts, None)
            with pytest.raises(RuntimeError, match=f"after the place\\(\\) of floor {floor}"):
                batch.outcomes(floor)
        actions = stream.integers(0, len(DISPLACEMENTS), floors * robots)
        found = batch.advance(actions.copy(), np.zeros(floors * robots, bool))
        for array in found[:5]:
            array[:] = 1  # they belong to the caller
        for floor, motion in enumerate(motions):
            chosen = actions[floor * robots :][:robots]
            moves = [DISPLACEMENTS[action] for action in chosen.tolist()]
            assert batch.outcomes(floor) == motion.advance(moves, [False] * robots)
