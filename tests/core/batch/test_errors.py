"""Invalid arguments and calls raise errors, and change nothing."""

import pickle
from typing import Any

import numpy as np
import pytest
from helpers.batches import CORRIDOR, DISABLED, EAST, ROOM, SHOP, SOUTH, WEST, over_modes

from warehouse_core import BackendError, Layout, LayoutError
from warehouse_core.batch import BatchEnv
from warehouse_core.world import tables as floor_tables


@pytest.mark.parametrize(
    ("actions", "error", "message"),
    [
        ([0, 1, 7], ValueError, r"the action of row 2 is 7; allowed: 0\.\.6"),
        ([0, -1, 9], ValueError, r"the action of row 1 is -1; allowed: 0\.\.6"),
        (np.array([2**64 - 1, 0, 0], np.uint64), ValueError, f"of row 0 is {2**64 - 1}"),
        ([1.0, 2, 3], TypeError, "the actions are float64; they must be integers"),
        (["N", "E", "S"], TypeError, "<U1"),
        ([1, 2], ValueError, r"the actions have the shape \(2,\); it must be \(3,\)"),
        (3, ValueError, r"\(\)"),
        (np.ones((3, 1), int), ValueError, r"\(3, 1\)"),
    ],
    ids=repr,
)
@over_modes
def test_invalid_actions_raise_and_change_nothing(mode, actions, error, message) -> None:
    batch = BatchEnv(3, max_steps=2, autoreset_mode=mode)
    batch.reset(seed=0)
    for _ in range(1 if mode == DISABLED else 2):
        batch.step([EAST, SOUTH, WEST])
    before = pickle.dumps(batch)
    with pytest.raises(error, match=message):
        batch.step(actions)
    assert pickle.dumps(batch) == before


@pytest.mark.parametrize(
    ("seed", "error", "message"),
    [
        (-1, ValueError, "seed is -1; it must be at least 0"),
        (1.5, TypeError, "seed is 1.5; it must be an integer or one for each row"),
        ([1, 2], ValueError, "2 seeds for 3 rows"),
        ([1, None, -2], ValueError, "the seed of row 2 is -2; it must be at least 0"),
        ([1, 2.0, 3], TypeError, "the seed of row 1 is 2.0"),
    ],
    ids=repr,
)
@pytest.mark.parametrize("mask", [None, np.array([True, False, False])], ids=["all", "mask"])
def test_invalid_seeds_raise_and_change_nothing(seed, mask, error, message) -> None:
    batch = BatchEnv(3)
    batch.reset(seed=0)
    batch.step([EAST, SOUTH, WEST])
    before = pickle.dumps(batch)
    with pytest.raises(error, match=message):
        batch.reset(seed, mask)
    assert pickle.dumps(batch) == before


@pytest.mark.parametrize(
    ("mask", "error", "message"),
    [
        ([True] * 3, TypeError, r"the mask is \[True, True, True\]; it must be an array of bool"),
        (np.ones(3, np.int8), TypeError, r"array of bool"),
        (np.ones(2, bool), ValueError, r"the mask has the shape \(2,\) and 2 rows set; the shape"),
        (np.zeros(3, bool), ValueError, "and 0 rows set; .* at least one row set"),
    ],
    ids=repr,
)
def test_invalid_masks_raise_and_change_nothing(mask: Any, error: type, message: str) -> None:
    batch = BatchEnv(3)
    batch.reset(seed=0)
    before = pickle.dumps(batch)
    with pytest.raises(error, match=message):
        batch.reset(5, mask)
    assert pickle.dumps(batch) == before


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"layout": [ROOM, ROOM]}, ValueError, "2 layouts for 3 rows"),
        ({"layout": [ROOM, ROOM, "..."]}, TypeError, "the layout of row 2 is str, not a Layout"),
        ({"layout": [ROOM, Layout(["#."]), ROOM]}, LayoutError, "two open cells .*; .* has 1"),
        ({"layout": Layout(["#"]), "randomize": False}, LayoutError, "no open cell"),
        ({"start_pos": (0, 0)}, LayoutError, "start_pos row 0, column 0 is wall"),
        ({"start_pos": [(1, 1), (1, 1), (1, 99)]}, LayoutError, r"start_pos\[2\] .* column 99"),
        ({"start_pos": [(1, 1), (2, 1)]}, ValueError, r"start_pos has the shape \(2, 2\); allowed"),
        (
            {"start_pos": [(1, 1), (1,), (1,)]},
            ValueError,
            r"start_pos has the shape \(3,\); allowed",
        ),
        ({"layout": {"rows": ROOM}}, TypeError, "layout is .*; it must be a Layout, or one for"),
        ({"backend": "boat"}, BackendError, "no backend is called 'boat'"),
    ],
    ids=repr,
)
def test_invalid_arguments_raise(settings: dict[str, Any], error: type, message: str) -> None:
    with pytest.raises(error, match=message):
        BatchEnv(**({"num_envs": 3} | settings))


def test_windows_above_the_limit_of_memory_raise(monkeypatch: pytest.MonkeyPatch) -> None:
    needed = 9 * (9 + 6)
    monkeypatch.setattr(floor_tables, "MAX_TABLE_BYTES", needed - 1)
    with pytest.raises(LayoutError, match=f"3 x 3 for 2 layouts take {needed} bytes; MAX_TABLE_BY"):
        BatchEnv(3, [SHOP, CORRIDOR, SHOP], view_radius=1)
    monkeypatch.setattr(floor_tables, "MAX_TABLE_BYTES", needed)
    assert BatchEnv(3, [SHOP, CORRIDOR, SHOP], view_radius=1).num_envs == 3
