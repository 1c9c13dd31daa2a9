import numpy as np
import pytest

from warehouse_core import random_layout
from warehouse_core.motion.grid import GridMotion
from warehouse_core.world.actions import DISPLACEMENTS

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)


@pytest.mark.parametrize(("floors", "robots"), [(3, 1), (3, 6), (1, 6), (1, 12)])
def test_the_outcomes_of_a_floor_are_those_of_the_single_motion(floors: int, robots: int) -> None:
    """This includes paths, headings and contacts, and floors that are placed again."""
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
