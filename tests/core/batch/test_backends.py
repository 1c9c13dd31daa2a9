"""A batch moves its robots by a backend."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from helpers.batches import CORRIDOR, EAST, NORTH, PICK, ROOM, WAIT

from warehouse_core import Layout
from warehouse_core.batch import BatchEnv
from warehouse_core.motion.grid import GridMotion


class Sticky(GridMotion):
    """A grid that records its calls, with fixed costs; its robots cannot move east."""

    def batch(self, layouts: Sequence[Layout]) -> Any:
        self.layouts, self.calls, self.closed = list(layouts), list[Any](), 0
        self.grid = super().batch(layouts)
        return self

    def place(self, rows: Any, cells: Any, seeds: Any = None) -> None:
        self.calls.append(("place", rows.tolist(), cells.tolist()))
        self.grid.place(rows, cells)

    def advance(self, actions: Any, loaded: Any) -> Any:
        self.calls.append(("advance", actions.tolist(), loaded.tolist()))
        east = actions == EAST
        outcome = self.grid.advance(np.where(east, WAIT, actions), loaded)
        return outcome._replace(
            blocked=outcome.blocked | east, seconds=np.array([2.5, 3.5]), joules=np.array([7.0, 8])
        )

    def close(self) -> None:
        self.closed += 1


def test_the_backend_moves_the_robots() -> None:
    motion = Sticky()
    layouts = [CORRIDOR, ROOM]
    batch = BatchEnv(2, layouts, [(0, 0), (2, 1)], max_steps=2, randomize=False, backend=motion)
    assert motion.layouts == layouts
    batch.reset()
    batch.step([PICK, NORTH])
    arrays, rewards, _, _, info = batch.step([EAST, EAST])
    assert arrays["robot_pos"].tolist() == [[0, 0], [1, 1]]
    assert rewards.tolist() == pytest.approx([-1.1, -1.1])
    assert {key: value.tolist() for key, value in info["motion"].items()} == {
        "blocked": [True, True],
        "seconds": [2.5, 3.5],
        "joules": [7.0, 8.0],
    }
    *_, info = batch.step([EAST, EAST])
    assert motion.calls == [
        ("place", [0, 1], [0, 11]),
        ("advance", [PICK, NORTH], [False, False]),
        ("advance", [EAST, EAST], [True, False]),
        ("place", [0, 1], [0, 11]),
        ("advance", [WAIT, WAIT], [False, False]),
    ]
    assert info["motion"]["seconds"].tolist() == info["motion"]["joules"].tolist() == [0, 0]
    batch.close()
    assert motion.closed == 1


def test_the_cost_depends_on_the_cell_size_of_the_backend() -> None:
    def joules(backend: Any) -> float:
        batch = BatchEnv(1, ROOM, randomize=False, backend=backend)
        batch.reset()
        return float(batch.step([EAST])[4]["motion"]["joules"][0])

    assert joules(GridMotion(2.0)) > joules("grid") == joules(GridMotion)
