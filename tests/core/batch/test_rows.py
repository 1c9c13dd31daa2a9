"""Each row of a batch equals a ``WarehouseEnv`` with the same actions."""

from typing import Any

import numpy as np
import pytest
from helpers.batches import (
    CHARGED,
    CORRIDOR,
    DISABLED,
    EAST,
    MIXED,
    NEXT_STEP,
    ROOM,
    SAME_STEP,
    TWO_CELLS,
    Single,
    Walk,
    some_batch,
)

from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.batch import BatchEnv
from warehouse_core.motion.grid import GridMotion


def walk_of(
    mode: str, randomize: bool | str, seed: int, layouts: list[Layout], **limits: Any
) -> Walk:
    rows = [Single(layout, randomize, **limits) for layout in layouts]
    return Walk(some_batch(mode, layouts, randomize=randomize, **limits), rows, seed)


@pytest.mark.parametrize(
    ("mode", "randomize", "radius"),
    [
        (NEXT_STEP, False, 0),
        (NEXT_STEP, True, 2),
        (SAME_STEP, False, 3),
        (SAME_STEP, True, 1),
        (DISABLED, False, 1),
        (DISABLED, True, 0),
        (NEXT_STEP, "start", 2),
        (SAME_STEP, "stations", 1),
    ],
)
def test_every_row_equals_a_single_warehouse(mode: str, randomize: bool | str, radius: int) -> None:
    """The episodes have bumps, deliveries, truncations and resets of some rows."""
    limits = {"max_steps": 23, "battery": 31 - 5 * radius, "view_radius": radius}
    walk = walk_of(mode, randomize, radius, MIXED, **limits)
    walk.go()
    assert walk.seen["blocked"] > 50
    assert walk.seen["delivered"] > 10
    assert walk.seen["truncated"] > 10
    assert (walk.seen["fresh"] > 20) == (mode == NEXT_STEP)
    assert not walk.seen["charged"]


@pytest.mark.parametrize(
    ("mode", "randomize", "radius"),
    [
        (NEXT_STEP, False, 0),
        (NEXT_STEP, True, 2),
        (SAME_STEP, "start", 1),
        (DISABLED, "stations", 1),
    ],
)
def test_every_row_with_chargers_equals_a_single_warehouse(mode, randomize, radius) -> None:
    """Batteries last from one step, after which a charger can still help, to a whole episode."""
    layouts = CHARGED if randomize in (False, "start") else CHARGED[:-1]
    for battery in (1, 5, 12, 60):
        limits = {"max_steps": 23, "battery": battery, "view_radius": radius}
        walk = walk_of(mode, randomize, radius, [*layouts, DEFAULT_LAYOUT], **limits)
        walk.go(60)
        assert (walk.seen["charged"] > 10) == (battery > 1)
        assert walk.seen["truncated"] > 3


def test_the_cost_depends_on_the_cell_size_of_the_backend_which_is_closed_at_the_end() -> None:
    def joules(backend: Any) -> float:
        batch = BatchEnv(1, ROOM, randomize=False, backend=backend)
        batch.reset()
        cost = float(batch.step([EAST])[4]["motion"]["joules"][0])
        batch.close()
        with pytest.raises(RuntimeError, match="after close"):
            batch.step([EAST])
        return cost

    assert joules(GridMotion(2.0)) > joules("grid") == joules(GridMotion)


def test_start_pos_is_one_cell_for_all_rows_or_one_for_each() -> None:
    one = BatchEnv(3, ROOM, (2, 3), randomize=False).reset()[0]["robot_pos"]
    assert one.tolist() == [[2, 3]] * 3
    for kind in (int, np.uint8, np.uint64, object):
        starts = np.array([(2, 1), (0, 4)], kind)
        each = BatchEnv(2, [ROOM, CORRIDOR], starts, randomize=False).reset()[0]["robot_pos"]
        assert each.tolist() == [[2, 1], [0, 4]]
    # Random stations leave no cell, so the start is the given one.
    two = BatchEnv(2, TWO_CELLS, [(0, 1), (2, 1)])
    for _ in range(3):
        assert two.reset()[0]["robot_pos"].tolist() == [[0, 1], [2, 1]]


def test_a_list_seeds_each_row_and_none_continues_its_stream() -> None:
    def starts(batch: BatchEnv, *seeds: Any) -> list[list[int]]:
        for seed in seeds:
            arrays, _ = batch.reset(seed)
        places = [arrays[key] for key in ("pickup_pos", "dropoff_pos", "robot_pos")]
        return np.concatenate(places, axis=1).tolist()

    def batch() -> BatchEnv:
        return BatchEnv(3)

    assert starts(batch(), [4, 8, 4]) == [starts(batch(), seed)[0] for seed in (4, 8, 4)]
    seventh, second, _ = starts(batch(), [7, 1, 0], [None, 2, None])
    assert second == starts(batch(), 2)[0]
    assert seventh == starts(batch(), 7, None)[0]
    assert starts(batch(), np.int64(5)) == starts(batch(), np.array([5, 6, 7]))
    assert starts(batch(), 5, None, None) == starts(batch(), 5, None, [None] * 3)
    assert len({str(starts(batch(), *[5, None, None][:count])) for count in (1, 2, 3)}) == 3
