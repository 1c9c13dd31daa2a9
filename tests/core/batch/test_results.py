"""A batch returns new arrays each time, and does not change its arguments."""

from typing import Any

import numpy as np
import pytest
from helpers.batches import CHARGED, DISABLED, MIXED, leaves, over_modes, same, some_batch

LAYOUTS = [*MIXED, *CHARGED[:-1]]

over_layouts = pytest.mark.parametrize("layouts", [MIXED, LAYOUTS], ids=["bare", "chargers"])


@over_modes
@over_layouts
def test_changing_returned_or_given_values_changes_nothing_else(mode, layouts) -> None:
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
