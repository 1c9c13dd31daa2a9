"""Each row of a batch equals a ``WarehouseEnv`` with the same actions."""

from collections import Counter
from typing import Any

import numpy as np
import pytest
from helpers.batches import (
    CHARGED,
    CORRIDOR,
    DISABLED,
    DROP,
    EAST,
    EMPTY,
    MIXED,
    MOTION,
    NEXT_STEP,
    PICK,
    ROOM,
    SAME_STEP,
    SHOP,
    WAIT,
    Single,
    some_batch,
)

from warehouse_core import DEFAULT_LAYOUT, Layout
from warehouse_core.arguments import MAX_STEPS
from warehouse_core.batch import BatchEnv


class Walk:
    """A batch and a single warehouse for each row, stepped with the same actions."""

    def __init__(
        self, mode: str, randomize: bool | str, seed: int, layouts: list[Layout], **limits: Any
    ) -> None:
        self.mode, self.seen = mode, Counter[str]()
        self.batch = some_batch(mode, layouts, randomize=randomize, **limits)
        self.rows = [Single(layout, randomize, **limits) for layout in layouts]
        for number, row in enumerate(self.rows):
            row.begin(seed + number)
        self.compare(*self.batch.reset(seed))

    def compare(self, arrays: Any, info: dict[str, Any]) -> None:
        for index, row in enumerate(self.rows):
            row.assert_seen(arrays, index, info["action_mask"])

    def reset(self, chosen: np.ndarray) -> None:
        """Reset some rows."""
        arrays, info = self.batch.reset(mask=chosen)
        for index in np.flatnonzero(chosen):
            self.rows[index].begin()
        assert set(info) == {"action_mask", "_action_mask"}
        assert info["_action_mask"].tolist() == chosen.tolist()
        self.compare(arrays, info)

    def step(self, actions: list[int]) -> None:
        arrays, rewards, terminated, truncated, info = self.batch.step(np.array(actions))
        assert (rewards.dtype, terminated.dtype, truncated.dtype) == (float, bool, bool)
        assert info["action_mask"].dtype == np.int8
        for index, row in enumerate(self.rows):
            verdict = (rewards[index], terminated[index], truncated[index])
            assert verdict == self.step_row(row, actions[index], index, info)
        self.compare(arrays, info)
        self.check_keys(info, terminated | truncated)

    def step_row(self, row: Single, action: int, index: int, info: dict[str, Any]) -> Any:
        """Step the single warehouse of a row, and compare its motion with info."""
        if row.ended:
            row.begin()
            assert not info["_motion"][index]
            assert [info["motion"][key][index] for key in MOTION] == [0, 0, 0]
            self.seen["fresh"] += 1
            return 0.0, False, False
        units = row.env.state.battery
        verdict = row.step(action)
        _, delivered, truncated = verdict
        blocked, *_ = moved = row.motion()
        self.seen.update({"delivered": delivered, "truncated": truncated, "blocked": blocked})
        self.seen["charged"] += row.env.state.battery > units
        source = info
        if row.ended and self.mode == SAME_STEP:
            source = info["final_info"]
            row.assert_seen(info["final_obs"], index, source["action_mask"])
            row.begin()
        assert info["_motion"][index] == (source is info)
        expected = tuple(source["motion"][key][index] for key in MOTION)
        assert moved == pytest.approx(expected, rel=1e-12)  # bodies add up joules in another order
        return verdict

    def go(self, steps: int = 90) -> None:
        """Take random steps, and reset rows now and then."""
        stream = np.random.default_rng(9)
        for number in range(steps):
            chosen = np.array([row.ended for row in self.rows])
            if self.mode != DISABLED:
                chosen |= stream.random(len(chosen)) < 0.3
            if chosen.any() and (self.mode == DISABLED or number % 15 == 14):
                self.reset(chosen)
            self.step([row.choose(stream) for row in self.rows])

    def check_keys(self, info: dict[str, Any], ended: np.ndarray) -> None:
        """Check the keys of info and the flags of the rows that they apply to."""
        finals = {"final_obs", "_final_obs", "final_info", "_final_info"}
        has_finals = self.mode == SAME_STEP and ended.any()
        keys = {"action_mask", "_action_mask", "motion", "_motion"}
        assert set(info) == (keys | finals if has_finals else keys)
        assert tuple(info["motion"]) == MOTION
        assert info["_action_mask"].all()
        if has_finals:
            final = info["final_info"]
            assert set(final) == keys
            assert set(final["motion"]) == {*MOTION, *(f"_{key}" for key in MOTION)}
            flags = [info["_final_obs"], info["_final_info"], final["_motion"]]
            flags += [final["_action_mask"], *(final["motion"][f"_{key}"] for key in MOTION)]
            assert all(flag.tolist() == ended.tolist() for flag in flags)


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
    """With bumps, deliveries, truncations and resets of some rows."""
    limits = {"max_steps": 23, "battery": 31 - 5 * radius, "view_radius": radius}
    walk = Walk(mode, randomize, radius, MIXED, **limits)
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
def test_every_row_with_chargers_equals_a_single_warehouse(
    mode: str, randomize: bool | str, radius: int
) -> None:
    """Batteries last from one step, which a charger still saves, to longer than any episode."""
    layouts = CHARGED if randomize in (False, "start") else CHARGED[:-1]
    for battery in (1, 5, 12, 60):
        limits = {"max_steps": 23, "battery": battery, "view_radius": radius}
        walk = Walk(mode, randomize, radius, [*layouts, DEFAULT_LAYOUT], **limits)
        walk.go(60)
        assert (walk.seen["charged"] > 10) == (battery > 1)
        assert walk.seen["truncated"] > 3


@pytest.mark.parametrize("randomize", [False, "start"])
def test_rows_of_bodies_with_chargers_equal_single_warehouses(randomize: bool | str) -> None:
    limits = {"max_steps": 23, "battery": 9, "view_radius": 1, "backend": "physics"}
    walk = Walk(NEXT_STEP, randomize, 3, CHARGED, **limits)
    walk.go(40)
    assert walk.seen["charged"] > 10


def test_a_nearly_full_battery_of_the_largest_size_charges() -> None:
    batch = BatchEnv(1, Layout(["PCD"]), (0, 1), battery=MAX_STEPS, randomize=False)
    batch.reset()
    assert batch.step([PICK])[0]["battery"].tolist() == [[MAX_STEPS - 1]]
    assert batch.step([WAIT])[0]["battery"].tolist() == [[MAX_STEPS]]
    assert batch.row(-1)[1].battery == MAX_STEPS


def test_a_delivery_in_the_last_step_terminates_and_truncates() -> None:
    batch = BatchEnv(1, ROOM, randomize=False, max_steps=4, autoreset_mode=SAME_STEP)
    batch.reset()
    for action in (PICK, EAST, EAST):
        batch.step([action])
    arrays, rewards, terminated, truncated, info = batch.step([DROP])
    assert (rewards[0], terminated[0], truncated[0]) == (pytest.approx(9.9), True, True)
    assert info["final_obs"]["steps"].tolist() == [[4]]
    assert info["final_obs"]["has_item"].tolist() == [0]
    assert arrays["steps"].tolist() == [[0]]


@pytest.mark.parametrize("kind", [np.uint8, np.uint64, object])
def test_starts_may_be_integers_of_any_type(kind: type) -> None:
    batch = BatchEnv(2, ROOM, start_pos=np.array([(1, 1), (2, 1)], kind), randomize=False)
    assert batch.reset()[0]["robot_pos"].tolist() == [[1, 1], [2, 1]]


def test_row_returns_the_layout_and_state_of_a_row() -> None:
    batch = some_batch()
    batch.reset(seed=5)
    rows = [Single(layout, True) for layout in MIXED]
    for number, row in enumerate(rows):
        row.begin(seed=5 + number)
    for _ in range(3):
        batch.step(np.full(len(rows), EAST))
    for index, row in enumerate(rows):
        for _ in range(3):
            row.step(EAST)
        layout, state = batch.row(index)
        assert (layout, state) == (row.env.layout, row.env.state)
        assert {type(number) for number in (*state.robot_pos, state.battery, state.steps)} == {int}
        assert state.has_item is False
    assert batch.row(-1) == batch.row(len(rows) - 1)
    fixed = some_batch(randomize=False)
    fixed.reset()
    assert [fixed.row(index)[0] for index in range(len(MIXED))] == MIXED


def test_the_size_is_the_largest_height_and_width() -> None:
    assert some_batch(layouts=[CORRIDOR, EMPTY, SHOP]).size == (3, 6)
