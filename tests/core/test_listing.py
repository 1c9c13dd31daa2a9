"""Subclasses that change the methods of the book's listing, as its readers write them."""

import copy
import json
import math
import pickle
import random
from collections.abc import Callable
from typing import Any

import pytest
from helpers.traces import TRACES, assert_as_recorded, env_of

from warehouse_core import (
    DEFAULT_LAYOUT,
    BackendError,
    BatchEnv,
    FleetEnv,
    GridMotion,
    LayoutError,
    WarehouseEnv,
    record_episode,
)
from warehouse_core.errors import EndedError
from warehouse_core.gymnasium_env import WarehouseGymnasiumEnv
from warehouse_core.listing import LISTED

HALL = ["#######", "#P...D#", "#.....#", "#######"]


class Actor:
    """An agent that takes given actions and then waits."""

    def __init__(self, *actions: str) -> None:
        self.actions = actions

    def reset(self) -> None:
        self.left = list(self.actions)

    def act(self, observation: Any) -> str:
        return self.left.pop(0) if self.left else "WAIT"


def subclass(**methods: Any) -> type[WarehouseEnv]:
    return type("Changed", (WarehouseEnv,), methods)


def hall(kind: type[WarehouseEnv], start: tuple[int, int] = (1, 1), **options: Any) -> WarehouseEnv:
    return kind(HALL, start, **options)


def noting(name: str, called: set[str]) -> Callable[..., Any]:
    """Return an override that does what the listing does, and notes that it was called."""

    def method(self: WarehouseEnv, *arguments: Any) -> Any:
        called.add(name)
        return getattr(WarehouseEnv, name)(self, *arguments)

    return method


def test_an_environment_composed_of_the_listings_methods_equals_the_recorded_one() -> None:
    called: set[str] = set()
    kind = subclass(**{name: noting(name, called) for name in LISTED})
    for trace in TRACES:
        env = env_of(trace)
        limits = env.max_steps, env.max_battery, env.view_radius
        assert_as_recorded(kind(env.layout, env.start_pos, *limits), trace)
    assert called == set(LISTED)


@pytest.mark.parametrize("name", LISTED)
def test_a_seed_draws_the_same_with_an_override(name: str) -> None:
    changed, plain = subclass(**{name: noting(name, set())})(), WarehouseEnv()
    before = random.getstate()
    for seed in range(10):
        for randomize in (True, "stations", "start"):
            assert changed.reset(randomize, seed) == plain.reset(randomize, seed)
            assert changed.grid == plain.grid
    assert random.getstate() == before


# Ten changes of the kind that the chapter asks for.


def test_walls_everywhere_stop_the_robot() -> None:
    env = hall(subclass(_is_wall=lambda self, r, c: True))
    assert env.step("E")[:2][1] == pytest.approx(-1.1)
    assert env.state.robot_pos == (1, 1)
    assert env.last_motion is not None
    assert env.last_motion.blocked


def test_a_warehouse_may_wrap_around() -> None:
    class Torus(WarehouseEnv):
        def _move(self, act: str) -> float:
            down, right = self.MOVE_DELTAS[act]
            row, col = self.state.robot_pos
            self.state.robot_pos = ((row + down) % self.height, (col + right) % self.width)
            return 0.0

    env = Torus(["P..", "..D"], (0, 0))
    assert env.step("W")[0]["robot_pos"] == (0, 2)
    assert env.last_motion is not None
    assert env.last_motion.path[:, 1].tolist() == [0.5, 2.5]
    assert not env.last_motion.blocked
    assert env.step("N")[0]["robot_pos"] == (1, 2)


def test_a_floor_may_be_slippery() -> None:
    class Slippery(WarehouseEnv):
        def _move(self, act: str) -> float:
            return super()._move("S" if act == "E" else act) - 0.25

    env = hall(Slippery)
    observation, reward, *_ = env.step("E")
    assert (observation["robot_pos"], reward) == ((2, 1), pytest.approx(-0.35))
    assert env.last_motion is not None
    assert env.last_motion.path[1, 2] == 2.5


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_sensor_may_fail(backend: str) -> None:
    class Blind(WarehouseEnv):
        def _observe(self) -> Any:
            return {**super()._observe(), "pickup_pos": None, "compass": "E"}

    env = hall(Blind, backend=backend)
    assert env.reset()["compass"] == env.observe()["compass"] == env.step("E")[0]["compass"] == "E"
    assert env.observe()["pickup_pos"] is None


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_picking_and_dropping_may_have_other_rewards(backend: str) -> None:
    class Priced(WarehouseEnv):
        def _pick(self) -> float:
            return super()._pick() - 2.0

        def _drop(self) -> float:
            self.state.has_item = False
            return self.price

        price = 9.09

    env = hall(Priced, backend=backend)
    assert env.step("PICK")[1] == pytest.approx(2.9)
    assert env.step("pick")[1] == pytest.approx(-2.6)
    assert env.step("DROP")[1:3] == (pytest.approx(8.99), False)
    env.price = 9.11
    assert env.step("DROP")[1:3] == (pytest.approx(9.01), True)
    assert env.step("W")[1] == pytest.approx(-1.1)
    assert env.step("E")[1] == pytest.approx(-0.1)


def test_actions_may_have_other_words() -> None:
    class Spoken(WarehouseEnv):
        def _normalize_action(self, action: Any) -> str:
            return {"right": "E", "stay": "wait"}.get(action) or super()._normalize_action(action)

    env = hall(Spoken)
    assert env.step("right")[0]["robot_pos"] == (1, 2)
    assert env.step("stay")[1] == pytest.approx(-0.15)
    assert env.step("left")[4] == {"invalid_action": True}
    assert env.step(3)[0]["robot_pos"] == (1, 1)


def test_stations_may_be_drawn_by_other_rules() -> None:
    class Corners(WarehouseEnv):
        def _randomize_pickup_dropoff(self) -> None:
            rows = [row.replace("P", ".").replace("D", ".") for row in self.grid]
            col = random.choice(range(1, 4))
            rows[1] = f"{rows[1][:col]}P{rows[1][col + 1 :]}"
            rows[2] = f"{rows[2][:5]}D#"
            self.grid = rows

    env = hall(Corners)
    first = env.reset(randomize=True, seed=3)
    assert (first["pickup_pos"], first["dropoff_pos"]) == (
        (1, random.Random(3).choice([1, 2, 3])),
        (2, 5),
    )
    for seed in range(5):
        env.reset(randomize=True, seed=seed)
    assert env.reset(randomize=True, seed=3) == first


def test_the_start_may_be_drawn_by_other_rules() -> None:
    env = hall(subclass(_random_empty_cell=lambda self: [2, 5]))
    assert env.reset(randomize=True, seed=1)["robot_pos"] == (2, 5)


def test_another_tile_may_be_found() -> None:
    class Nearest(WarehouseEnv):
        def _find_tile(self, tile: str) -> Any:
            here = self.state.robot_pos
            cells = [(r, c) for r in (0, 1) for c in range(5) if self.grid[r][c] == tile]
            return min(cells, key=lambda cell: math.dist(cell, here), default=None)

    env = Nearest(["P...P", "....."], (1, 3))
    assert env.reset()["pickup_pos"] == (0, 4)
    assert env.step("W")[0]["pickup_pos"] == (0, 0)
    assert env.observe()["dropoff_pos"] is None


def test_waiting_on_a_charger_still_charges() -> None:
    env = subclass(_pick=lambda self: 0.0)(["C."], (0, 0), battery=20)
    env.state.battery = 5
    assert env.step("WAIT")[0]["battery"] == 14


# The grid.


def test_a_row_of_the_grid_can_be_assigned() -> None:
    env = hall(WarehouseEnv)
    env.grid[1] = "#P#..D#"
    assert env.layout.rows[1] == env.grid[1] == "#P#..D#"
    assert env.step("E")[1] == pytest.approx(-1.1)
    assert env.reset(True, seed=1)["robot_pos"] != (1, 2)
    assert env.grid[1][2] == "#"
    grid = env.grid
    grid[2] = "#.P...#"
    assert grid == env.grid == grid.copy()
    env.grid = DEFAULT_LAYOUT  # type: ignore[assignment]
    assert env.height == 7


def test_a_grid_that_does_not_fit_changes_nothing() -> None:
    env = hall(WarehouseEnv)
    env.step("E")
    with pytest.raises(LayoutError, match="the robot's cell, row 1, column 2 is wall"):
        env.grid[1] = "#P#..D#"
    with pytest.raises(LayoutError, match="start_pos row 1, column 1 is wall"):
        env.grid[1] = "##...D#"
    with pytest.raises(LayoutError, match="row 1 has 3 columns where row 0 has 7"):
        env.grid[1] = "###"
    assert env.grid == HALL


@pytest.mark.parametrize("change", ["append", "__delitem__", "__iadd__", "sort"])
def test_a_grid_refuses_what_would_change_only_a_copy(change: str) -> None:
    with pytest.raises(TypeError, match=r"env\.grid\[row\] = "):
        getattr(WarehouseEnv().grid, change)(0)


def test_a_copied_grid_is_a_plain_list() -> None:
    env = WarehouseEnv()
    grid = env.grid
    for copied in (copy.deepcopy(grid), copy.copy(grid), pickle.loads(pickle.dumps(grid))):
        assert type(copied) is list
        assert copied == env.grid == json.loads(json.dumps(env.grid))


# What cannot be honoured is refused.


@pytest.mark.parametrize("name", ["_move", "_is_wall"])
def test_a_body_refuses_other_moves(name: str) -> None:
    kind = subclass(**{name: noting(name, set())})
    expected = f"Changed overrides {name}, which backend 'physics' does not call.*backend='grid'"
    with pytest.raises(BackendError, match=expected):
        kind(backend="physics")

    class Lazy(GridMotion):
        def advance(self, displacements: Any, loaded: Any) -> Any:
            return super().advance([(0, 0)], loaded)

    with pytest.raises(BackendError, match=name):
        kind(backend=Lazy)
    assert kind(backend=GridMotion).step("E")[0]["robot_pos"] == (1, 2)


@pytest.mark.parametrize("kind", [BatchEnv, FleetEnv, WarehouseGymnasiumEnv])
@pytest.mark.parametrize("name", LISTED)
def test_other_environments_refuse_an_override_when_it_is_defined(kind: type, name: str) -> None:
    expected = (
        f"Changed defines {name}, which {kind.__name__} never calls; .* subclass of Warehouse"
    )
    with pytest.raises(TypeError, match=expected):
        type("Changed", (kind,), {name: lambda self: None})


@pytest.mark.parametrize(
    "changed", [{"ACTIONS": ["N", "NE"]}, {"MOVE_DELTAS": {"NE": (-1, 1)}}], ids=str
)
def test_other_actions_are_refused(changed: dict[str, Any]) -> None:
    with pytest.raises(
        TypeError, match=r"Changed changes ACTIONS or MOVE_DELTAS.*_normalize_action"
    ):
        subclass(**changed)


@pytest.mark.parametrize(
    ("methods", "action", "error", "expected"),
    [
        ({"_move": lambda self, act: None}, "E", ValueError, "reward of Changed._move is None"),
        ({"_pick": lambda self: "5"}, "PICK", ValueError, "reward of Changed._pick is '5'"),
        ({"_is_wall": lambda self, r, c: False}, "N", LayoutError, "row -1, column 0 is off the"),
        ({"_normalize_action": lambda self, action: 1.5}, "N", TypeError, "action 1.5 is float"),
    ],
)
def test_what_an_override_returns_is_checked(methods, action, error, expected) -> None:
    env = subclass(**methods)(["P.D"], (0, 0))
    with pytest.raises(error, match=expected):
        env.step(action)


def test_a_failed_draw_changes_nothing() -> None:
    env = hall(subclass(_random_empty_cell=lambda self: (0, 0)))
    before = env.layout
    with pytest.raises(LayoutError, match="the start at row 0, column 0 is wall"):
        env.reset(randomize=True)
    assert env.layout is before
    env.grid[1] = "#PD...#"
    assert env.step("E")[0]["dropoff_pos"] == (1, 2)


def test_a_closed_environment_cannot_be_stepped() -> None:
    env = subclass(_move=lambda self, act: 0.0)()
    env.close()
    with pytest.raises(RuntimeError, match=r"carry\(\) needs a reset\(\)"):
        env.step("E")


def test_observe_and_its_name_in_the_listing_are_one_method() -> None:
    parent = subclass(observe=lambda self: {"seen": 1})
    assert parent()._observe() == parent().step("E")[0] == {"seen": 1}
    child = type("Child", (parent,), {"_observe": lambda self: {"seen": 2}})
    assert child().observe() == {"seen": 2}
    both = subclass(observe=lambda self: self._observe(), _observe=lambda self: {"seen": 3})
    assert both().step("E")[0] == {"seen": 3}


# Records of environments that somebody else changes.


@pytest.mark.parametrize("meddle", ["reset", "step", "change"])
@pytest.mark.parametrize("before", [0, 2])
def test_an_agent_that_meddles_with_its_environment_is_refused(meddle: str, before: int) -> None:
    env = hall(WarehouseEnv)

    class Meddling(Actor):
        def act(self, observation: Any) -> str:
            if observation["steps"] == before:
                if meddle == "change":
                    env.grid[2] = "#...#.#"
                else:
                    getattr(env, meddle)(*["E"] * (meddle == "step"))
            return "WAIT"

    with pytest.raises(EndedError, match="was reset, stepped or given another layout between"):
        record_episode(env, Meddling(), randomize=False)


@pytest.mark.parametrize("before", [0, 2])
def test_an_agent_of_a_fleet_cannot_reset_it(before: int) -> None:
    class Resetting:
        def reset(self) -> None:
            pass

        def act(self, env: FleetEnv) -> list[str]:
            if env.steps == before:
                env.reset(seed=5)
            return ["WAIT", "WAIT"]

    with pytest.raises(EndedError, match="was reset, stepped"):
        record_episode(FleetEnv(robots=2, max_steps=9), Resetting())


def test_a_robot_can_be_put_on_another_cell_between_listed_steps() -> None:
    env = hall(subclass(_move=noting("_move", set())))
    env.state.robot_pos = (2, 3)
    assert env.step("E")[0]["robot_pos"] == (2, 4)
    assert env.last_motion is not None
    assert env.last_motion.path[0, 1:3].tolist() == [3.5, 2.5]
