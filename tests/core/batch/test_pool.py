"""Each episode of a row has a random layout from a pool."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from helpers.batches import CORRIDOR, ROOM, Single, Walk, over_modes, over_starts

from warehouse_core import BackendError, Layout, LayoutError, random_layout
from warehouse_core.batch import BatchEnv
from warehouse_core.motion.grid import GridMotion

ROWS = 6
POOL = [random_layout(5, 7, density, seed=seed) for seed, density in enumerate((0.0, 0.2, 0.4))]
POOL.append(Layout(["#######", "##....#", "#.#P#.#", "#.D..C#", "#######"]))


class FromPool(Single):
    """A single warehouse with a random layout from the pool, which is chosen before the start."""

    chosen: Counter[Layout]

    def begin(self, seed: int | None = None) -> None:
        if seed is not None:
            self.stream = np.random.default_rng(seed)
        self.layout = POOL[int(self.stream.random() * len(POOL))]
        self.default_start = self.layout.default_start()
        self.chosen[self.layout] += 1
        super().begin()


@over_modes
@over_starts
@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_each_row_equals_a_single_environment_in_the_layouts_it_draws(
    mode: str, randomize: bool | str, backend: str
) -> None:
    limits: dict[str, Any] = {"max_steps": 9, "battery": 8, "backend": backend}
    batch = BatchEnv(ROWS, pool=POOL, randomize=randomize, autoreset_mode=mode, **limits)
    FromPool.chosen = Counter()
    Walk(batch, [FromPool(POOL[0], randomize, **limits) for _ in range(ROWS)], seed=5).go(24)
    assert set(FromPool.chosen) == set(POOL)


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"pool": POOL, "layout": ROOM}, ValueError, "layout and pool are both given"),
        ({"pool": []}, ValueError, "pool is empty"),
        ({"pool": "..D"}, TypeError, "pool is '..D'; it must be a sequence of Layout"),
        ({"pool": [ROOM, "..D"]}, TypeError, "it must be a sequence of Layout"),
        (
            {"pool": [ROOM, CORRIDOR]},
            LayoutError,
            "layout 1 of the pool is 1 x 6 and layout 0 4 x 5; all must have one size",
        ),
        (
            {"pool": POOL, "start_pos": [(1, 1)] * ROWS},
            ValueError,
            r"start_pos is \[.*\]; with a pool it must be one cell",
        ),
        ({"pool": [Layout(["#.#"])]}, LayoutError, "randomize needs two open cells"),
    ],
)
def test_a_pool_that_cannot_be_used_raises(settings, error, message) -> None:
    with pytest.raises(error, match=message):
        BatchEnv(ROWS, **settings)


def test_a_backend_whose_layouts_cannot_change_has_no_pool() -> None:
    class Fixed(GridMotion):
        def batch(self, layouts: Sequence[Layout]) -> Any:
            class Batch:
                place = advance = close = None

            return Batch()

    with pytest.raises(BackendError, match=r"cannot change layouts.* change\(floors, layouts\)"):
        BatchEnv(ROWS, pool=POOL, backend=Fixed)
