"""What a batch returns is new each time, and its arguments are not changed."""

import pickle
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from helpers.batches import CHARGED, DISABLED, MIXED, leaves, over_modes, same, some_batch

from warehouse_core import Layout
from warehouse_core.batch import BatchEnv

LAYOUTS = [*MIXED, *CHARGED[:-1]]

over_layouts = pytest.mark.parametrize("layouts", [MIXED, LAYOUTS], ids=["bare", "chargers"])


@over_modes
@over_layouts
def test_returned_values_do_not_change_later(mode: str, layouts: list[Layout]) -> None:
    batch = some_batch(mode, layouts, max_steps=5)
    moves = np.random.default_rng(2).integers(7, size=(12, len(layouts)))
    kept: list[Any] = [batch.reset(seed=0)]
    copies = [pickle.dumps(kept[0])]
    for actions in moves:
        kept.append(batch.step(actions))
        kept.append(batch.action_masks())
        if mode == DISABLED and batch._ended().any():
            kept.append(batch.reset(mask=batch._ended().copy()))
        copies += [pickle.dumps(each) for each in kept[len(copies) :]]
    kept.append(batch.reset())
    assert all(same(each, pickle.loads(copy)) for each, copy in zip(kept, copies, strict=False))
    arrays = [array for each in kept for array in leaves(each)]
    assert not any(np.shares_memory(one, other) for one, other in combinations(arrays, 2))


@over_modes
@over_layouts
def test_changing_returned_or_given_values_changes_nothing_else(
    mode: str, layouts: list[Layout]
) -> None:
    batch, twin = (some_batch(mode, layouts, max_steps=5) for _ in range(2))
    moves = np.random.default_rng(2).integers(7, size=(12, len(layouts)))

    def check(found: Any, expected: Any) -> None:
        assert same(found, expected)
        for array in leaves(found):
            array[...] = array == 0

    check(batch.reset(seed=0), twin.reset(seed=0))
    for actions in moves:
        given = actions.copy()
        check(batch.step(given), twin.step(actions.copy()))
        assert np.array_equal(given, actions), "the given actions have changed"
        check(batch.action_masks(), twin.action_masks())
        if mode == DISABLED and twin._ended().any():
            ended, given = (twin._ended().copy() for _ in range(2))
            check(batch.reset(mask=given), twin.reset(mask=ended))
            assert np.array_equal(given, ended), "the given mask has changed"
        for row in range(len(layouts)):
            layout, state = batch.row(row)
            assert (layout, state) == twin.row(row)
            state.battery, state.robot_pos = 0, (9, 9)


@pytest.mark.parametrize("kind", [list, tuple, np.int8, np.uint64])
def test_actions_are_integers_of_any_type(kind: Any) -> None:
    batch, twin = BatchEnv(7), BatchEnv(7)
    batch.reset(seed=3), twin.reset(seed=3)
    actions = np.arange(7)
    given = kind(actions.tolist()) if kind in (list, tuple) else actions.astype(kind)
    assert same(batch.step(given), twin.step(actions))
