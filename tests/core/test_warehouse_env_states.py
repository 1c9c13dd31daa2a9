"""Any sequence of operations on an environment agrees with an independent implementation."""

import random
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from warehouse_core import WarehouseEnv

Cell = tuple[int, int]

GRIDS = [
    ["############", "#..P....#..#", "#..##...#..#", "#......##..#", "#..#.......#", "#..#..D....#",
     "############"],
    [".P.", "#D.", "..."],
    ["PDPD", "....", "D#P."],
    ["....."],
    ["PD"],
    [".#."],
    ["P"],
    ["P.C.", "CD..", "..C#"],
    ["CP.D"],
    ["C.C."],
]  # fmt: skip
WORDS = ["N", "E", "S", "W", "WAIT", "PICK", "DROP"]
DIRECTIONS = {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}

valid_actions = (
    st.sampled_from(WORDS)
    | st.sampled_from(WORDS).map(str.lower)
    | st.integers(0, 6)
    | st.integers(0, 6).map(np.int64)
    | st.integers(0, 6).map(np.uint8)
)
invalid_actions = st.sampled_from(["", "fly", "NN", "7", -1, 7, 10**20, np.int64(-3), np.int8(7)])
no_actions = st.sampled_from([None, 1.5, [], b"N", np.float64(2), (0,)])


class Oracle:
    """The chapter's warehouse, and chargers, from the table alone, without code of the project."""

    def __init__(self, rows: list[str], start: Cell, max_steps: int, battery: int) -> None:
        self.given, self.start = rows, start
        self.rows = [list(row) for row in rows]
        self.max_steps, self.max_battery = max_steps, battery
        self.begin(start)

    def begin(self, cell: Cell) -> None:
        self.cell, self.loaded, self.steps = cell, False, 0
        self.battery = self.max_battery

    def cells(self, tile: str) -> list[Cell]:
        return [
            (r, c)
            for r, row in enumerate(self.rows)
            for c, found in enumerate(row)
            if found == tile
        ]

    def is_open(self, cell: Cell) -> bool:
        row, col = cell
        inside = 0 <= row < len(self.rows) and 0 <= col < len(self.rows[0])
        return inside and self.rows[row][col] != "#"

    def forget_draws(self) -> None:
        self.rows = [list(row) for row in self.given]

    def draw(self, stream: random.Random) -> None:
        """Draw as the recorded episodes do: stations from the cells that were empty before."""
        empty = self.cells(".")
        for row, col in self.cells("P") + self.cells("D"):
            self.rows[row][col] = "."
        if len(empty) >= 2:
            for tile in "PD":
                row, col = stream.choice(empty)
                empty.remove((row, col))
                self.rows[row][col] = tile
        left = self.cells(".")
        self.begin(stream.choice(left) if left else self.start)

    def step(self, word: str) -> tuple[float, bool]:
        """Return reward and terminated."""
        self.steps += 1
        self.battery -= 1
        tile = self.rows[self.cell[0]][self.cell[1]]
        if word in DIRECTIONS:
            target = (self.cell[0] + DIRECTIONS[word][0], self.cell[1] + DIRECTIONS[word][1])
            if not self.is_open(target):
                return -0.1 - 1.0, False
            self.cell = target
            return -0.1, False
        if word == "WAIT":
            if tile == "C":
                self.battery = min(self.battery + 10, self.max_battery)
            return -0.1 - 0.05, False
        if word == "PICK" and tile == "P" and not self.loaded:
            self.loaded = True
            return -0.1 + 5.0, False
        if word == "DROP" and tile == "D" and self.loaded:
            self.loaded = False
            return -0.1 + 10.0, True
        return -0.1 - 0.5, False

    def observation(self, radius: int) -> dict[str, Any]:
        row, col = self.cell
        window = [
            "".join(self._seen(r, c) for c in range(col - radius, col + radius + 1))
            for r in range(row - radius, row + radius + 1)
        ]
        return {
            "local_grid": window,
            "robot_pos": self.cell,
            "has_item": self.loaded,
            "battery": self.battery,
            "steps": self.steps,
            "pickup_pos": next(iter(self.cells("P")), None),
            "dropoff_pos": next(iter(self.cells("D")), None),
        }

    def _seen(self, row: int, col: int) -> str:
        if (row, col) == self.cell:
            return "r" if self.loaded else "R"
        return self.rows[row][col] if self.is_open((row, col)) else "#"


class EnvironmentMachine(RuleBasedStateMachine):
    @initialize(
        rows=st.sampled_from(GRIDS),
        data=st.data(),
        max_steps=st.integers(1, 30),
        battery=st.integers(1, 30),
        radius=st.integers(0, 3),
    )
    def build(
        self, rows: list[str], data: st.DataObject, max_steps: int, battery: int, radius: int
    ) -> None:
        everywhere = [(r, c) for r, row in enumerate(rows) for c, t in enumerate(row) if t != "#"]
        start = data.draw(st.sampled_from(everywhere))
        self.radius, self.everywhere = radius, everywhere
        self.has_room = len(everywhere) - "".join(rows).count("C") >= 2
        self.env = WarehouseEnv(rows, start, max_steps, battery, radius)
        self.oracle = Oracle(rows, start, max_steps, battery)
        self.earned = self.owed = 0.0
        self.observation = self.env.reset()

    @rule(action=valid_actions)
    def step(self, action: Any) -> None:
        word = action.upper() if isinstance(action, str) else WORDS[action]
        self._step(action, word, {})

    @rule(action=invalid_actions)
    def step_with_an_invalid_action(self, action: Any) -> None:
        self._step(action, "invalid", {"invalid_action": True})

    def _step(self, action: Any, word: str, expected_info: dict[str, bool]) -> None:
        loaded_before = self.oracle.loaded
        self.observation, reward, terminated, truncated, info = self.env.step(action)
        expected, ended = self.oracle.step(word)
        self.earned += reward
        self.owed += expected
        out_of_time = self.oracle.steps >= self.oracle.max_steps
        out_of_charge = self.oracle.battery <= 0
        assert reward == pytest.approx(expected, abs=1e-9)
        assert type(reward) is float
        assert (terminated, truncated) == (ended, out_of_time or out_of_charge)
        assert info == expected_info
        if self.env.state.has_item != loaded_before:
            assert word == ("DROP" if loaded_before else "PICK")

    @rule(action=no_actions)
    def step_with_what_is_no_action(self, action: Any) -> None:
        with pytest.raises(TypeError):
            self.env.step(action)

    @rule(seed=st.none() | st.integers(0, 2**70))
    def reset(self, seed: int | None) -> None:
        self.observation = self.env.reset(seed=seed)
        self.oracle.begin(self.oracle.start)

    @precondition(lambda self: self.has_room)
    @rule(seed=st.integers(0, 2**70), privately=st.booleans())
    def reset_at_random(self, seed: int, privately: bool) -> None:
        random.seed(seed + 1 if privately else seed)
        before = random.getstate()
        self.observation = self.env.reset(randomize=True, seed=seed if privately else None)
        assert not privately or random.getstate() == before
        if privately:
            self.oracle.forget_draws()
        self.oracle.draw(random.Random(seed))

    @precondition(lambda self: not self.has_room)
    @rule(seed=st.none() | st.integers(0, 2**70))
    def reset_at_random_without_room(self, seed: int | None) -> None:
        before = random.getstate()
        with pytest.raises(ValueError, match=r"needs two open cells .* the layout has [01]"):
            self.env.reset(randomize=True, seed=seed)
        assert random.getstate() == before

    @rule(data=st.data())
    def put_the_robot_elsewhere(self, data: st.DataObject) -> None:
        cell = data.draw(st.sampled_from(self.everywhere))
        self.env.state.robot_pos = cell
        self._look_again(cell, self.oracle.loaded)

    @rule(loaded=st.booleans())
    def fill_or_empty_its_hands(self, loaded: bool) -> None:
        self.env.state.has_item = loaded
        self._look_again(self.oracle.cell, loaded)

    def _look_again(self, cell: Cell, loaded: bool) -> None:
        """Take a step: only a step shows a change of the state."""
        self.oracle.cell, self.oracle.loaded = cell, loaded
        self.step("WAIT")

    @rule()
    def spoil_the_last_observation(self) -> None:
        self.observation["local_grid"].clear()
        self.observation.clear()
        self.step("WAIT")

    @invariant()
    def the_observation_is_the_oracles(self) -> None:
        if hasattr(self, "env"):
            assert self.observation == self.oracle.observation(self.radius)

    @invariant()
    def the_state_adds_up(self) -> None:
        if hasattr(self, "env"):
            state = self.env.state
            spent = self.env.max_battery - state.battery
            assert spent <= state.steps if self.env.layout.chargers else spent == state.steps
            assert self.oracle.is_open(state.robot_pos)
            assert self.env.grid == ["".join(row) for row in self.oracle.rows]
            assert self.earned == pytest.approx(self.owed, abs=1e-9)


EnvironmentMachine.TestCase.settings = settings(max_examples=30, stateful_step_count=40)
TestEnvironment = EnvironmentMachine.TestCase
