"""Batches of warehouses, and the single warehouse that each of their rows equals."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from warehouse_core import DEFAULT_LAYOUT, Cell, Layout, WarehouseEnv, random_layout
from warehouse_core.batch import AUTORESET_MODES, BatchEnv
from warehouse_core.task.encoding import encode
from warehouse_core.task.rules import useful_actions

NEXT_STEP, SAME_STEP, DISABLED = AUTORESET_MODES
NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

TWO_CELLS = Layout(["#.#", "###", "#.#"])
"""Random stations use both cells, so the robot starts on one of them."""

FULL = Layout(["P", "D"])
"""Its own stations use both cells."""

SHOP = Layout(["P.D", "D#P", "..P"])
EMPTY = Layout(["....", ".##."])
CORRIDOR = Layout(["P....D"])
ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])

MIXED = [
    *(random_layout(4 + size, 9 - size, 0.3, seed=size) for size in range(5)),
    *(TWO_CELLS, SHOP, EMPTY, CORRIDOR, SHOP, ROOM, DEFAULT_LAYOUT, FULL),
]
"""Layouts of different sizes, some twice, with none, one or several stations."""

CHARGED = [
    *(Layout(["P.C", ".#.", "CDP"]), Layout(["C.C", "#C."]), Layout(["C..C", "P#D."])),
    *(Layout(["PCCD"]), ROOM, Layout(["CC", "CC"])),
]
"""Layouts with chargers and one without; the last has no room for anything else."""

MOTION = ("blocked", "seconds", "joules")

over_modes = pytest.mark.parametrize("mode", AUTORESET_MODES)
over_starts = pytest.mark.parametrize("randomize", [False, True, "stations", "start"])


def randomized(
    layout: Layout, stream: np.random.Generator, default_start: Cell, randomize: bool | str
) -> tuple[Layout, Cell]:
    """Choose pickup, dropoff and start at random, each from the cells that are left."""
    left = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    left = [cell for cell in left if cell not in layout.chargers]
    places = stream.random(4)
    if randomize == "start":
        left = [cell for cell in left if cell not in layout.pickups + layout.dropoffs]
    else:
        pickup, dropoff = (left.pop(int(place * len(left))) for place in places[:2])
        layout = layout.with_stations(pickup, dropoff)
    if randomize == "stations" or not left:
        return layout, default_start
    return layout, left[int(places[2] * len(left))]


class Single:
    """A single warehouse, to compare with a row of a batch."""

    def __init__(
        self, layout: Layout, randomize: bool | str, start: Cell | None = None, **limits: Any
    ):
        self.layout, self.randomize = layout, randomize
        self.default_start = start or layout.default_start()
        self.env = WarehouseEnv(layout, self.default_start, **limits)
        self.ended = False

    def begin(self, seed: int | None = None) -> None:
        """Start an episode."""
        layout, start = self.layout, self.default_start
        if seed is not None:
            self.stream = np.random.default_rng(seed)
        if self.randomize:
            layout, start = randomized(layout, self.stream, start, self.randomize)
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
        """Return an action, often one that helps to deliver, otherwise a random one."""
        layout, state = self.env.layout, self.env.state
        mask, chance = self.mask(), stream.random()
        if chance < 0.6 and (mask[PICK] or mask[DROP]):
            return PICK if mask[PICK] else DROP
        if chance < 0.8 and state.robot_pos in layout.chargers:
            return WAIT
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
        """Compare the state with a row of an observation and of the masks."""
        expected: dict[str, Any] = {**encode(self.env.observe())}
        assert list(arrays) == list(expected)
        for key, value in expected.items():
            found = arrays[key][row]
            assert found.dtype == np.asarray(value).dtype, key
            assert np.array_equal(found, value), (key, row, found, value)
        assert mask[row].tolist() == self.mask()


class Walk:
    """A batch and a single warehouse for each row, stepped with the same actions."""

    def __init__(self, batch: BatchEnv, rows: Sequence[Single], seed: int) -> None:
        self.mode, self.seen = batch.autoreset_mode, Counter[str]()
        self.batch, self.rows = batch, rows
        for number, row in enumerate(self.rows):
            row.begin(seed + number)
        self.compare(*self.batch.reset(seed))

    def compare(self, arrays: Any, info: dict[str, Any]) -> None:
        for index, row in enumerate(self.rows):
            row.assert_seen(arrays, index, info["action_mask"])
            assert self.batch.row(index) == (row.env.layout, row.env.state)

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
        motion = info["motion"]
        assert set(motion) == {*MOTION, *(f"_{key}" for key in MOTION)}
        assert all(motion[f"_{key}"].tolist() == info["_motion"].tolist() for key in MOTION)
        assert info["_action_mask"].all()
        if has_finals:
            final = info["final_info"]
            assert set(final) == keys
            assert set(final["motion"]) == {*MOTION, *(f"_{key}" for key in MOTION)}
            flags = [info["_final_obs"], info["_final_info"], final["_motion"]]
            flags += [final["_action_mask"], *(final["motion"][f"_{key}"] for key in MOTION)]
            assert all(flag.tolist() == ended.tolist() for flag in flags)


def some_batch(mode: str = NEXT_STEP, layouts: Any = None, **settings: Any) -> BatchEnv:
    layouts = MIXED if layouts is None else layouts
    return BatchEnv(len(layouts), layouts, autoreset_mode=mode, **settings)


def leaves(data: Any) -> Iterator[np.ndarray]:
    """Yield every array in the results of a batch."""
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
