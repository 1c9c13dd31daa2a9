"""Batches of warehouses, and the single warehouse that each of their rows equals."""

from collections.abc import Iterator
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


def drawn(
    layout: Layout, stream: np.random.Generator, usual: Cell, randomize: bool | str
) -> tuple[Layout, Cell]:
    """Draw pickup, dropoff and start, one after the other, from the cells that are left."""
    left = [layout.open_cell(index) for index in range(len(layout.open_cells))]
    left = [cell for cell in left if cell not in layout.chargers]
    places = stream.random(4)
    if randomize == "start":
        left = [cell for cell in left if cell not in layout.pickups + layout.dropoffs]
    else:
        pickup, dropoff = (left.pop(int(place * len(left))) for place in places[:2])
        layout = layout.with_stations(pickup, dropoff)
    if randomize == "stations" or not left:
        return layout, usual
    return layout, left[int(places[2] * len(left))]


class Single:
    """A single warehouse, to compare with a row of a batch."""

    def __init__(
        self, layout: Layout, randomize: bool | str, start: Cell | None = None, **limits: Any
    ):
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
            layout, start = drawn(layout, self.stream, start, self.randomize)
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
