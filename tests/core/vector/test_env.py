"""A batch against its definition: each row is a ``WarehouseEnv`` fed the same actions."""

import pickle
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from warehouse_core import (
    DEFAULT_LAYOUT,
    BackendError,
    Cell,
    Layout,
    LayoutError,
    WarehouseEnv,
    random_layout,
)
from warehouse_core.errors import EndedError
from warehouse_core.gymnasium_env.env import WarehouseGymnasiumEnv
from warehouse_core.motion.grid import GridMotion
from warehouse_core.task.encoding import encode
from warehouse_core.task.rules import useful_actions
from warehouse_core.vector.env import AUTORESET_MODES, BatchEnv
from warehouse_core.world import tables as floor_tables

NEXT_STEP, SAME_STEP, DISABLED = AUTORESET_MODES
NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

TWO_CELLS = Layout(["#.#", "###", "#.#"])
"""Pickup and dropoff take both, so the robot starts on one of them."""

SHOP = Layout(["P.D", "D#P", "..P"])
EMPTY = Layout(["....", ".##."])
CORRIDOR = Layout(["P....D"])
ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])

MIXED = [
    *(random_layout(4 + size, 9 - size, 0.3, seed=size) for size in range(5)),
    *(TWO_CELLS, SHOP, EMPTY, CORRIDOR, SHOP, ROOM, DEFAULT_LAYOUT),
]
"""Of different sizes, some of them twice, with several stations and with none."""

MOTION = ("blocked", "seconds", "joules")

over_modes = pytest.mark.parametrize("mode", AUTORESET_MODES)
over_starts = pytest.mark.parametrize("randomize", [False, True], ids=["as given", "drawn"])


def drawn(layout: Layout, stream: np.random.Generator, usual: Cell) -> tuple[Layout, Cell]:
    """Take cells for pickup, dropoff and start, one after the other, out of those left."""
    left = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    places = stream.random(4)
    pickup, dropoff = (left.pop(int(place * len(left))) for place in places[:2])
    start = left[int(places[2] * len(left))] if left else usual
    return layout.with_stations(pickup, dropoff), start


class Single:
    """One row by itself."""

    def __init__(self, layout: Layout, randomize: bool, start: Cell | None = None, **limits: int):
        self.layout, self.randomize = layout, randomize
        self.usual = start or layout.usual_start()
        self.env = WarehouseEnv(layout, self.usual, **limits)
        self.ended = False

    def begin(self, seed: int | None = None) -> None:
        """Start an episode."""
        layout, start = self.layout, self.usual
        if seed is not None:
            self.stream = np.random.default_rng(seed)
        if self.randomize:
            layout, start = drawn(layout, self.stream, start)
        self.env.reset_to(layout, start)
        self.ended = False

    def step(self, action: int) -> tuple[float, bool, bool]:
        _, reward, terminated, truncated, _ = self.env.step(action)
        self.ended = terminated or truncated
        return reward, terminated, truncated

    def mask(self) -> list[bool]:
        state, layout = self.env.state, self.env.layout
        row, col = state.robot_pos
        sides = layout.open_sides((row, col))
        return list(useful_actions(sides, layout.rows[row][col], state.has_item))

    def choose(self, stream: np.random.Generator) -> int:
        """Return an action, now and then any, but rather one that gets on with the job."""
        layout, state = self.env.layout, self.env.state
        mask, chance = self.mask(), stream.random()
        if chance < 0.6 and (mask[PICK] or mask[DROP]):
            return PICK if mask[PICK] else DROP
        targets = layout.dropoffs if state.has_item else layout.pickups
        if chance > 0.6 or not targets:
            return int(stream.integers(7))
        row, col = (there - here for there, here in zip(targets[0], state.robot_pos, strict=True))
        if row and (not col or stream.random() < 0.5):
            return SOUTH if row > 0 else NORTH
        return EAST if col > 0 else WEST

    def motion(self) -> tuple[bool, float, float]:
        motion = self.env.last_motion
        assert motion is not None
        return motion.blocked, motion.seconds, motion.joules

    def assert_seen(self, arrays: Any, row: int, mask: Any) -> None:
        """Compare with row number ``row`` of an observation and of the masks."""
        expected: dict[str, Any] = {**encode(self.env.observe())}
        assert list(arrays) == list(expected)
        for key, value in expected.items():
            found = arrays[key][row]
            assert found.dtype == np.asarray(value).dtype, key
            assert np.array_equal(found, value), (key, row, found, value)
        assert mask[row].tolist() == self.mask()


def some_batch(mode: str = NEXT_STEP, layouts: Any = None, **settings: Any) -> BatchEnv:
    layouts = MIXED if layouts is None else layouts
    return BatchEnv(len(layouts), layouts, autoreset_mode=mode, **settings)


def leaves(data: Any) -> Iterator[np.ndarray]:
    """Yield every array in what a batch returns."""
    if isinstance(data, np.ndarray):
        yield data
    elif isinstance(data, (dict, tuple)):
        for value in data.values() if isinstance(data, dict) else data:
            yield from leaves(value)


def same(data: Any, other: Any) -> bool:
    """Return whether the results of two batches are equal, with their types."""
    if isinstance(data, np.ndarray):
        return data.dtype == other.dtype and np.array_equal(data, other)
    if isinstance(data, dict):
        return list(data) == list(other) and all(same(data[key], other[key]) for key in data)
    if isinstance(data, tuple):
        return len(data) == len(other) and all(map(same, data, other))
    return type(data) is type(other) and data == other


# What a row is.


class Walk:
    """A batch and the single warehouses that its rows should be, on the same way."""

    def __init__(self, mode: str, randomize: bool, seed: int, **limits: int) -> None:
        self.mode, self.seen = mode, Counter[str]()
        self.batch = some_batch(mode, randomize=randomize, **limits)
        self.rows = [Single(layout, randomize, **limits) for layout in MIXED]
        for number, row in enumerate(self.rows):
            row.begin(seed + number)
        self.compare(*self.batch.reset(seed))

    def compare(self, arrays: Any, info: dict[str, Any]) -> None:
        for index, row in enumerate(self.rows):
            row.assert_seen(arrays, index, info["action_mask"])

    def reset(self, chosen: np.ndarray) -> None:
        """Begin anew with some rows."""
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
        """Do in a single warehouse what the batch should have done in its row."""
        if row.ended:
            row.begin()
            assert not info["_motion"][index]
            self.seen["fresh"] += 1
            return 0.0, False, False
        verdict = row.step(action)
        _, delivered, cut = verdict
        blocked, *_ = moved = row.motion()
        self.seen.update({"delivered": delivered, "cut off": cut, "blocked": blocked})
        told = info
        if row.ended and self.mode == SAME_STEP:
            told = info["final_info"]
            row.assert_seen(info["final_obs"], index, told["action_mask"])
            row.begin()
        assert info["_motion"][index] == (told is info)
        assert moved == tuple(told["motion"][key][index] for key in MOTION)
        return verdict

    def check_keys(self, info: dict[str, Any], ended: np.ndarray) -> None:
        """Compare the flags that say which rows each part of info is about."""
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
    ],
)
def test_every_row_is_what_a_single_warehouse_would_be(
    mode: str, randomize: bool, radius: int
) -> None:
    """Through episodes that end either way, bumps, and resets of some rows."""
    limits = {"max_steps": 23, "battery": 31 - 5 * radius, "view_radius": radius}
    walk, stream = Walk(mode, randomize, seed=radius, **limits), np.random.default_rng(9)
    for number in range(90):
        chosen = np.array([row.ended for row in walk.rows])
        if mode != DISABLED:
            chosen |= stream.random(len(chosen)) < 0.3
        if chosen.any() and (mode == DISABLED or number % 15 == 14):
            walk.reset(chosen)
        walk.step([row.choose(stream) for row in walk.rows])
    assert walk.seen["blocked"] > 50
    assert walk.seen["delivered"] > 10
    assert walk.seen["cut off"] > 10
    assert (walk.seen["fresh"] > 20) == (mode == NEXT_STEP)


@pytest.mark.parametrize(("max_steps", "battery"), [(3, 9), (9, 3), (1, 1)])
def test_the_lower_of_steps_and_battery_cuts_an_episode_off(max_steps: int, battery: int) -> None:
    batch = BatchEnv(2, max_steps=max_steps, battery=battery, autoreset_mode=DISABLED)
    batch.reset(seed=0)
    for number in range(min(max_steps, battery)):
        arrays, _, terminated, truncated, _ = batch.step([WAIT, WAIT])
        assert arrays["battery"].tolist() == [[battery - number - 1]] * 2
        assert arrays["steps"].tolist() == [[number + 1]] * 2
        assert not terminated.any()
        assert truncated.tolist() == [number + 1 == min(max_steps, battery)] * 2


def test_a_delivery_with_the_last_step_is_both_an_end_and_a_cut() -> None:
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


def test_the_step_after_an_end_takes_no_action() -> None:
    batch = BatchEnv(2, ROOM, start_pos=[(1, 1), (2, 1)], randomize=False, max_steps=2)
    batch.reset()
    batch.step([PICK, NORTH])
    batch.step([EAST, EAST])
    arrays, rewards, terminated, truncated, info = batch.step([EAST, DROP])
    assert arrays["robot_pos"].tolist() == [[1, 1], [2, 1]]
    assert arrays["has_item"].tolist() == [0, 0]
    assert arrays["battery"].tolist() == [[200], [200]]
    assert (rewards.tolist(), terminated.any(), truncated.any()) == ([0.0, 0.0], False, False)
    assert info["_motion"].tolist() == [False, False]
    assert info["motion"]["seconds"].tolist() == info["motion"]["joules"].tolist() == [0.0, 0.0]


def test_a_row_tells_the_layout_and_state_that_it_has() -> None:
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


def test_the_size_is_that_of_the_tallest_and_of_the_widest() -> None:
    assert some_batch(layouts=[CORRIDOR, EMPTY, SHOP]).size == (3, 6)


# Where rows begin.


@over_starts
def test_rows_start_as_single_environments_with_seeds_that_follow_each_other(
    randomize: bool,
) -> None:
    batch = some_batch(randomize=randomize)
    singles = [WarehouseGymnasiumEnv(layout, randomize=randomize) for layout in MIXED]
    for seed in (7, None, None, 2**40, None):
        arrays, _ = batch.reset(seed)
        for row, env in enumerate(singles):
            expected, _ = env.reset(seed=None if seed is None else seed + row)
            for key, value in expected.items():
                assert np.array_equal(arrays[key][row], value), (key, row)


def test_a_start_is_one_for_all_rows_or_one_for_each() -> None:
    one = BatchEnv(3, ROOM, (2, 3), randomize=False).reset()[0]["robot_pos"]
    each = BatchEnv(2, [ROOM, CORRIDOR], [(2, 1), (0, 4)], randomize=False).reset()[0]["robot_pos"]
    assert one.tolist() == [[2, 3]] * 3
    assert each.tolist() == [[2, 1], [0, 4]]
    two = BatchEnv(2, TWO_CELLS, [(0, 1), (2, 1)])
    for _ in range(3):
        assert two.reset()[0]["robot_pos"].tolist() == [[0, 1], [2, 1]], "no cell is left to draw"


def test_a_list_seeds_each_row_and_none_lets_its_stream_go_on() -> None:
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


def test_rows_without_a_seed_differ_from_each_other_and_from_run_to_run() -> None:
    big = random_layout(40, 40, 0.2, seed=0)
    places = [BatchEnv(20, big).reset()[0]["robot_pos"].tolist() for _ in range(2)]
    assert places[0] != places[1]
    assert len({tuple(place) for place in places[0]}) > 10


def test_starts_are_uniform_over_all_triples_of_cells() -> None:
    layout, count = Layout([".#.", "#.#", ".#."]), 6_000
    batch = BatchEnv(count, layout)
    seen: Counter[tuple[int, ...]] = Counter()
    for seed in (0, None):
        arrays, _ = batch.reset(seed)
        keys = ("pickup_pos", "dropoff_pos", "robot_pos")
        seen.update(map(tuple, np.concatenate([arrays[key] for key in keys], axis=1).tolist()))
    expected = 2 * count / (5 * 4 * 3)
    assert len(seen) == 60
    # 98.3 is passed once in a thousand seeds by 59 degrees of freedom; the seed here is fixed.
    assert sum((number - expected) ** 2 / expected for number in seen.values()) < 98.3


@over_starts
@over_modes
def test_a_reset_with_a_mask_leaves_other_rows_alone(mode: str, randomize: bool) -> None:
    """Their state, their episode and what they will draw later."""
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


@over_modes
def test_the_same_seed_and_actions_give_the_same_episodes_again(mode: str) -> None:
    batch = some_batch(NEXT_STEP if mode == DISABLED else mode, max_steps=9)
    moves = np.random.default_rng(3).integers(7, size=(30, len(MIXED)))
    first, second = (
        [batch.reset(seed=11), *map(batch.step, moves), batch.reset(), *map(batch.step, moves[:5])]
        for _ in range(2)
    )
    assert all(map(same, first, second))


# What is returned.


@over_modes
def test_nothing_that_was_returned_changes_later(mode: str) -> None:
    batch = some_batch(mode, max_steps=5)
    moves = np.random.default_rng(2).integers(7, size=(12, len(MIXED)))
    kept: list[Any] = [batch.reset(seed=0)]
    copies = [pickle.dumps(kept[0])]
    for actions in moves:
        kept.append(batch.step(actions))
        kept.append(batch.action_masks())
        if mode == DISABLED and batch._ended.any():
            kept.append(batch.reset(mask=batch._ended.copy()))
        copies += [pickle.dumps(each) for each in kept[len(copies) :]]
    kept.append(batch.reset())
    assert all(same(each, pickle.loads(copy)) for each, copy in zip(kept, copies, strict=False))
    arrays = [array for each in kept for array in leaves(each)]
    assert not any(np.shares_memory(one, other) for one, other in combinations(arrays, 2))


@over_modes
def test_nothing_that_was_returned_or_given_is_used_later(mode: str) -> None:
    batch, twin = (some_batch(mode, max_steps=5) for _ in range(2))
    moves = np.random.default_rng(2).integers(7, size=(12, len(MIXED)))

    def check(found: Any, expected: Any) -> None:
        assert same(found, expected)
        for array in leaves(found):
            array[...] = array == 0

    check(batch.reset(seed=0), twin.reset(seed=0))
    for actions in moves:
        given = actions.copy()
        check(batch.step(given), twin.step(actions.copy()))
        assert np.array_equal(given, actions), "the caller's actions stay as they are"
        check(batch.action_masks(), twin.action_masks())
        if mode == DISABLED and twin._ended.any():
            ended, given = (twin._ended.copy() for _ in range(2))
            check(batch.reset(mask=given), twin.reset(mask=ended))
            assert np.array_equal(given, ended), "nor is the caller's mask what is returned"
        for row in range(len(MIXED)):
            layout, state = batch.row(row)
            assert (layout, state) == twin.row(row)
            state.battery, state.robot_pos = 0, (9, 9)


@pytest.mark.parametrize("kind", [list, tuple, np.int8, np.uint64])
def test_actions_are_integers_of_any_kind(kind: Any) -> None:
    batch, twin = BatchEnv(7), BatchEnv(7)
    batch.reset(seed=3), twin.reset(seed=3)
    actions = np.arange(7)
    given = kind(actions.tolist()) if kind in (list, tuple) else actions.astype(kind)
    assert same(batch.step(given), twin.step(actions))


# What is refused.


@pytest.mark.parametrize(
    ("actions", "error", "message"),
    [
        ([0, 1, 7], ValueError, r"the action of row 2 is 7; allowed: 0\.\.6"),
        ([0, -1, 9], ValueError, r"the action of row 1 is -1; allowed: 0\.\.6"),
        (np.array([2**64 - 1, 0, 0], np.uint64), ValueError, f"of row 0 is {2**64 - 1}"),
        (np.array([0, 0, 2**63 + 1], np.uint64), ValueError, f"of row 2 is {2**63 + 1}"),
        (np.array([0, -128, 0], np.int8), ValueError, "of row 1 is -128"),
        ([1.0, 2, 3], TypeError, "the actions are float64; they must be integers"),
        ([1, np.nan, 3], TypeError, "float64"),
        (np.ones(3, bool), TypeError, "the actions are bool"),
        (["N", "E", "S"], TypeError, "<U1"),
        ([1, 2, None], TypeError, "object"),
        (None, TypeError, "object"),
        ([1, 2], ValueError, r"the actions have the shape \(2,\); it must be \(3,\)"),
        (3, ValueError, r"\(\)"),
        ([[1, 2, 3]], ValueError, r"\(1, 3\)"),
        (np.ones((3, 1), int), ValueError, r"\(3, 1\)"),
    ],
    ids=repr,
)
@over_modes
def test_actions_that_cannot_be_carried_out_change_nothing(
    mode: str, actions: Any, error: type, message: str
) -> None:
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
        ({1, 2, 3}, TypeError, "seed is {1, 2, 3}"),
        ("abc", TypeError, "seed is 'abc'; it must be an integer or one for each row"),
        (np.array(3), TypeError, "seed is array"),
        ([1, 2], ValueError, "2 seeds for 3 rows"),
        ([], ValueError, "0 seeds for 3 rows"),
        ([1, None, -2], ValueError, "the seed of row 2 is -2; it must be at least 0"),
        ([1, 2.0, 3], TypeError, "the seed of row 1 is 2.0"),
        (np.array([1.0, 2.0, 3.0]), TypeError, "the seed of row 0 is"),
    ],
    ids=repr,
)
@pytest.mark.parametrize("mask", [None, np.array([True, False, False])], ids=["all", "mask"])
def test_bad_seeds_change_nothing(seed: Any, mask: Any, error: type, message: str) -> None:
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
        (np.ones((3, 1), bool), ValueError, r"\(3, 1\)"),
        (np.zeros(3, bool), ValueError, "and 0 rows set; .* at least one row set"),
    ],
    ids=repr,
)
def test_bad_masks_change_nothing(mask: Any, error: type, message: str) -> None:
    batch = BatchEnv(3)
    batch.reset(seed=0)
    before = pickle.dumps(batch)
    with pytest.raises(error, match=message):
        batch.reset(5, mask)
    assert pickle.dumps(batch) == before


@over_starts
@over_modes
def test_before_the_first_reset_there_is_nothing_to_step(mode: str, randomize: bool) -> None:
    batch = some_batch(mode, randomize=randomize)
    before = pickle.dumps(batch)
    with pytest.raises(EndedError, match=r"step\(\) needs a reset\(\) before it"):
        batch.step(np.zeros(len(MIXED), int))
    with pytest.raises(EndedError, match=r"the first reset\(\) must be of all rows"):
        batch.reset(mask=np.ones(len(MIXED), bool))
    with pytest.raises(EndedError, match=r"action_masks\(\) needs a reset\(\) before it"):
        batch.action_masks()
    with pytest.raises(EndedError, match=r"row\(\) needs a reset\(\) before it"):
        batch.row(0)
    assert pickle.dumps(batch) == before


def test_rows_that_have_ended_must_be_reset_where_nothing_else_resets_them() -> None:
    batch = BatchEnv(4, CORRIDOR, randomize=False, max_steps=5, autoreset_mode=DISABLED)
    batch.reset()
    batch.step([WAIT] * 4)
    batch.reset(mask=np.array([True, False, False, True]))
    for _ in range(4):
        *_, truncated, info = batch.step([EAST] * 4)
    assert truncated.tolist() == [False, True, True, False]
    assert set(info) == {"motion", "_motion", "action_mask", "_action_mask"}
    before = pickle.dumps(batch)
    with pytest.raises(EndedError, match="2 rows have ended, row 1 first; they must be reset"):
        batch.step([EAST] * 4)
    assert pickle.dumps(batch) == before
    batch.reset(mask=np.array([False, True, False, False]))
    with pytest.raises(EndedError, match="1 rows have ended, row 2 first"):
        batch.step([EAST] * 4)
    batch.reset(mask=np.array([False, False, True, False]))
    arrays, *_ = batch.step([EAST] * 4)
    assert arrays["steps"].tolist() == [[5], [1], [1], [5]]


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"num_envs": 0}, ValueError, "num_envs is 0; it must be at least 1"),
        ({"num_envs": "3"}, TypeError, "num_envs is '3'"),
        ({"max_steps": 0}, ValueError, "max_steps is 0; it must be at least 1"),
        ({"battery": 0}, ValueError, "battery is 0; it must be at least 1"),
        ({"view_radius": -1}, ValueError, "view_radius is -1; it must be at least 0"),
        ({"autoreset_mode": "Never"}, ValueError, "is 'Never'; allowed: NextStep, SameStep, Dis"),
        ({"layout": [ROOM, ROOM]}, ValueError, "2 layouts for 3 rows"),
        ({"layout": [ROOM, ROOM, "..."]}, TypeError, "the layout of row 2 is str, not a Layout"),
        ({"layout": [ROOM, Layout(["#."]), ROOM]}, LayoutError, "two open cells .*; .* has 1"),
        ({"layout": Layout(["#"]), "randomize": False}, LayoutError, "no open cell"),
        ({"start_pos": (0, 0)}, LayoutError, "start_pos row 0, column 0 is wall"),
        (
            {"start_pos": [(1, 1), (1, 1), (1, 99)]},
            LayoutError,
            r"start_pos\[2\] .* column 99",
        ),
        ({"start_pos": [(1, 1), (2, 1)]}, ValueError, r"start_pos has the shape \(2, 2\); allowed"),
        ({"start_pos": (1.0, 1.0)}, TypeError, r"start_pos is .* two integers"),
        ({"backend": "boat"}, BackendError, "no backend is called 'boat'"),
    ],
    ids=repr,
)
def test_a_batch_that_could_not_work_is_not_made(
    settings: dict[str, Any], error: type, message: str
) -> None:
    with pytest.raises(error, match=message):
        BatchEnv(**({"num_envs": 3} | settings))


def test_windows_that_would_fill_the_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    needed = 9 * (9 + 6)
    monkeypatch.setattr(floor_tables, "MAX_TABLE_BYTES", needed - 1)
    with pytest.raises(LayoutError, match=f"3 x 3 for 2 layouts take {needed} bytes; MAX_TABLE_BY"):
        BatchEnv(3, [SHOP, CORRIDOR, SHOP], view_radius=1)
    monkeypatch.setattr(floor_tables, "MAX_TABLE_BYTES", needed)
    assert BatchEnv(3, [SHOP, CORRIDOR, SHOP], view_radius=1).num_envs == 3


# What moves the robots.


class Sticky(GridMotion):
    """A grid whose robots cannot go east, takes note of what it is told, and has a price."""

    def batch(self, layouts: Sequence[Layout]) -> Any:
        self.layouts, self.told, self.closed = list(layouts), list[Any](), 0
        self.grid = super().batch(layouts)
        return self

    def place(self, rows: Any, cells: Any) -> None:
        self.told.append(("place", rows.tolist(), cells.tolist()))
        self.grid.place(rows, cells)

    def advance(self, actions: Any, loaded: Any) -> Any:
        self.told.append(("advance", actions.tolist(), loaded.tolist()))
        east = actions == EAST
        outcome = self.grid.advance(np.where(east, WAIT, actions), loaded)
        return outcome._replace(
            blocked=outcome.blocked | east, seconds=np.array([2.5, 3.5]), joules=np.array([7.0, 8])
        )

    def close(self) -> None:
        self.closed += 1


def test_moves_are_those_of_the_backend() -> None:
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
    assert motion.told == [
        ("place", [0, 1], [0, 11]),
        ("advance", [PICK, NORTH], [False, False]),
        ("advance", [EAST, EAST], [True, False]),
        ("place", [0, 1], [0, 11]),
        ("advance", [WAIT, WAIT], [False, False]),
    ]
    assert info["motion"]["seconds"].tolist() == info["motion"]["joules"].tolist() == [0, 0]
    batch.close()
    assert motion.closed == 1


def test_a_backend_that_cannot_be_multiplied_says_so() -> None:
    class Lone(GridMotion):
        batch = None  # type: ignore[assignment]

    with pytest.raises(BackendError, match=r"cannot move a batch; .* a method batch\(layouts\)"):
        BatchEnv(2, backend=Lone)


def test_the_cell_size_of_the_backend_sets_the_price() -> None:
    def joules(backend: Any) -> float:
        batch = BatchEnv(1, ROOM, randomize=False, backend=backend)
        batch.reset()
        return float(batch.step([EAST])[4]["motion"]["joules"][0])

    assert joules(GridMotion(2.0)) > joules("grid") == joules(GridMotion)
