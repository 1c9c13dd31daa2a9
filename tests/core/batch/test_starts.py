"""The starts of the rows of a batch."""

from typing import Any

import numpy as np
import pytest
from helpers.batches import (
    CHARGED,
    CORRIDOR,
    MIXED,
    ROOM,
    TWO_CELLS,
    over_modes,
    over_starts,
    same,
    some_batch,
)

from warehouse_core import Layout, random_layout
from warehouse_core.batch import BatchEnv
from warehouse_core.gymnasium_env.env import WarehouseGymnasiumEnv


@over_starts
@pytest.mark.parametrize("layouts", [MIXED, CHARGED[:-1]])
def test_rows_start_like_single_environments_with_consecutive_seeds(
    randomize: bool | str, layouts: list[Layout]
) -> None:
    batch = some_batch(layouts=layouts, randomize=randomize)
    singles = [WarehouseGymnasiumEnv(layout, randomize=randomize) for layout in layouts]
    for seed in (7, None, None, 2**40, None):
        arrays, _ = batch.reset(seed)
        for row, env in enumerate(singles):
            expected, _ = env.reset(seed=None if seed is None else seed + row)
            for key, value in expected.items():
                assert np.array_equal(arrays[key][row], value), (key, row)


def test_start_pos_is_one_cell_for_all_rows_or_one_for_each() -> None:
    one = BatchEnv(3, ROOM, (2, 3), randomize=False).reset()[0]["robot_pos"]
    each = BatchEnv(2, [ROOM, CORRIDOR], [(2, 1), (0, 4)], randomize=False).reset()[0]["robot_pos"]
    assert one.tolist() == [[2, 3]] * 3
    assert each.tolist() == [[2, 1], [0, 4]]
    # Random stations leave no cell, so the start is the given one.
    two = BatchEnv(2, TWO_CELLS, [(0, 1), (2, 1)])
    for _ in range(3):
        assert two.reset()[0]["robot_pos"].tolist() == [[0, 1], [2, 1]], (
            "no cell is left, so the start is not random"
        )


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


def test_rows_without_a_seed_differ_from_each_other_and_between_batches() -> None:
    big = random_layout(40, 40, 0.2, seed=0)
    places = [BatchEnv(20, big).reset()[0]["robot_pos"].tolist() for _ in range(2)]
    assert places[0] != places[1]
    assert len({tuple(place) for place in places[0]}) > 10


@over_starts
@over_modes
def test_a_reset_with_a_mask_does_not_change_other_rows(mode: str, randomize: bool | str) -> None:
    """Neither their state nor their random stream."""
    batch, twin = (some_batch(mode, randomize=randomize, max_steps=30) for _ in range(2))
    moves = np.random.default_rng(0).integers(7, size=(3, len(MIXED)))
    for each in (batch, twin):
        each.reset(seed=1)
        for actions in moves:
            each.step(actions)
    mask = np.arange(len(MIXED)) % 3 == 0
    # A list gives no seed to rows that are not reset.
    arrays, info = batch.reset(list(range(100, 100 + len(MIXED))), mask)
    assert info["_action_mask"].tolist() == mask.tolist()
    assert np.array_equal(info["action_mask"], batch.action_masks())
    assert (arrays["steps"][:, 0] == np.where(mask, 0, 3)).all()
    mask[:] = True
    expected = some_batch(randomize=randomize)
    expected.reset(seed=100)
    for row in range(len(MIXED)):
        assert batch.row(row) == (expected if row % 3 == 0 else twin).row(row)
    assert same(
        batch.reset(mask=np.arange(len(MIXED)) == 1)[0]["robot_pos"][1],
        twin.reset()[0]["robot_pos"][1],
    )
