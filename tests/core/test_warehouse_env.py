import copy
import inspect
import random
from typing import Any
from unittest.mock import Mock

import pytest
from helpers.traces import TRACES, as_json, assert_as_recorded, env_of, over_traces

from warehouse_core import (
    DEFAULT_LAYOUT,
    GridMotion,
    Layout,
    LayoutError,
    WarehouseEnv,
    WarehouseState,
)


def everything(env: WarehouseEnv) -> tuple[object, ...]:
    """Return all state that a failed call must not change, including Python's random state."""
    layout_and_state = (env.layout, env.grid, copy.copy(env.state), env.last_motion)
    return (*layout_and_state, env.render_with_legend(), random.getstate())


# The recorded episodes.


@over_traces
def test_recorded_episodes_are_reproduced(trace: dict[str, Any]) -> None:
    env = env_of(trace)
    assert_as_recorded(env, trace)


def test_a_seed_draws_like_the_global_random_and_leaves_it_unchanged() -> None:
    random.seed("anything")
    before = random.getstate()
    for trace in TRACES[::5]:
        env, episode = env_of(trace), trace["episodes"][0]
        observation = env.reset(randomize=episode["randomize"], seed=episode["seed"])
        assert as_json(observation) == episode["first_observation"]
        drawn = Layout(env.grid)
        stations = (observation["pickup_pos"], observation["dropoff_pos"])
        assert stations == (next(iter(drawn.pickups), None), next(iter(drawn.dropoffs), None))
    assert random.getstate() == before


@pytest.mark.parametrize("randomize", [True, "stations"])
def test_a_seed_determines_an_episode_however_often_the_environment_was_used(randomize) -> None:
    used = WarehouseEnv()
    for seed in range(30):
        expected = WarehouseEnv().reset(randomize, seed)
        assert used.reset(randomize, seed) == expected
    elsewhere = Layout(["P....", ".....", "....D"])
    used.reset_to(elsewhere)
    for seed in range(5):
        assert used.reset(randomize, seed) == WarehouseEnv(elsewhere).reset(randomize, seed)


def test_without_a_seed_the_previous_stations_are_not_drawn_again() -> None:
    env = WarehouseEnv(["P....D"], (0, 1))
    for seed in range(30):
        before = {*env.layout.pickups, *env.layout.dropoffs}
        random.seed(seed)
        env.reset(randomize=True)
        assert before.isdisjoint(env.layout.pickups + env.layout.dropoffs)


# The interface.


def test_the_constructor_is_as_in_the_chapter() -> None:
    parameters = inspect.signature(WarehouseEnv).parameters.values()
    positional = {p.name: p.default for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD}
    assert list(positional.items()) == [
        ("grid", None),
        ("start_pos", (1, 1)),
        ("max_steps", 200),
        ("battery", 200),
        ("view_radius", 2),
    ]
    assert all(p.kind is p.KEYWORD_ONLY for p in parameters if p.name not in positional)


def test_the_attributes_are_as_in_the_chapter() -> None:
    env = WarehouseEnv(["...", ".PD"], (1, 0), 9, 8, 1)
    assert env.ACTIONS == ["N", "E", "S", "W", "WAIT", "PICK", "DROP"]
    assert env.MOVE_DELTAS == {"N": (-1, 0), "E": (0, 1), "S": (1, 0), "W": (0, -1)}
    assert (env.grid, env.height, env.width) == (["...", ".PD"], 2, 3)
    assert (env.start_pos, env.max_steps, env.max_battery, env.view_radius) == ((1, 0), 9, 8, 1)
    assert env.state == WarehouseState((1, 0), has_item=False, battery=8, steps=0)


def test_the_default_grid_is_as_in_the_chapter() -> None:
    env = WarehouseEnv()
    assert env.layout is WarehouseEnv(DEFAULT_LAYOUT).layout is DEFAULT_LAYOUT
    assert env.reset() == {
        "local_grid": ["#####", "#####", "##R.P", "##..#", "##..."],
        "robot_pos": (1, 1),
        "has_item": False,
        "battery": 200,
        "steps": 0,
        "pickup_pos": (1, 3),
        "dropoff_pos": (5, 6),
    }


def test_a_start_of_none_is_the_default_start() -> None:
    env = WarehouseEnv(["#P", "D#"], start_pos=None)
    assert env.start_pos == env.reset()["robot_pos"] == (0, 1)
    assert WarehouseEnv(start_pos=None).start_pos == (1, 1)
    assert env.reset_to(DEFAULT_LAYOUT)["robot_pos"] == (1, 1)
    assert env.reset_to(DEFAULT_LAYOUT, (1, 2))["robot_pos"] == (1, 2)


def test_a_reset_to_a_wall_raises_and_changes_nothing() -> None:
    env = WarehouseEnv()
    before = everything(env)
    with pytest.raises(LayoutError, match="start_pos row 0, column 0 is wall; it must be an open"):
        env.reset_to(Layout(["#."]), (0, 0))
    assert everything(env) == before


def test_the_rewards_of_a_delivery_follow_the_table() -> None:
    env = WarehouseEnv([".P.", "#.D"], start_pos=(0, 0))
    words = ["W", "PICK", "e", 5, "PICK", "E", "DROP", "S", "drop"]
    steps = [env.step(word) for word in words]
    rewards = [-1.1, -0.6, -0.1, 4.9, -0.6, -0.1, -0.6, -0.1, 9.9]
    assert [reward for _, reward, *_ in steps] == pytest.approx(rewards)
    assert [terminated for _, _, terminated, *_ in steps] == [False] * 8 + [True]
    loaded = [observation["has_item"] for observation, *_ in steps]
    assert loaded == [False] * 3 + [True] * 5 + [False]
    assert [info for *_, info in steps] == [{}] * 9


def test_render_shows_the_robot_on_top() -> None:
    env = WarehouseEnv(["#P.", ".D#"], start_pos=(0, 1))
    assert env.render_grid() == [["#", "R", "."], [".", "D", "#"]]
    env.step("PICK")
    assert env.render() == "#r.\n.D#"
    assert env.render_with_legend() == (
        "#r.\n.D#\n\nLegend:\n# = wall\n. = empty\nP = pickup\nD = dropoff\n"
        "R = robot (empty)\nr = robot (loaded)"
    )


def test_the_legend_explains_chargers_where_there_are_any() -> None:
    env = WarehouseEnv(["#C.D"], start_pos=(0, 2))
    assert "\nD = dropoff\nC = charger\nR = robot (empty)\n" in env.render_with_legend()
    env.reset_to(Layout(["#..D"]))
    assert "charger" not in env.render_with_legend()


def test_last_motion_is_the_outcome_of_the_backend() -> None:
    env = WarehouseEnv(["..#"], start_pos=(0, 0))
    assert env.last_motion is None
    env.step("E")
    assert env.last_motion is not None
    assert (env.last_motion.cell, env.last_motion.blocked) == ((0, 1), False)
    env.step("E")
    assert env.last_motion.blocked
    env.step("fly")
    assert not env.last_motion.blocked
    env.reset()
    assert env.last_motion is None


def test_a_closed_environment_can_be_closed_again_but_not_stepped() -> None:
    env = WarehouseEnv()
    env.close()
    env.close()
    with pytest.raises(RuntimeError, match="reset"):
        env.step("E")


# The state can be assigned.


def test_a_robot_put_on_another_cell_is_rendered_there() -> None:
    env = WarehouseEnv()
    env.state.robot_pos = (1, 10)
    assert env.render_grid()[1][10] == "R"
    env.step("WAIT")
    assert env.last_motion is not None
    assert env.last_motion.path[0, 1:3].tolist() == [10.5, 1.5]


def test_the_state_can_be_replaced() -> None:
    env = WarehouseEnv(["P.D"], start_pos=(0, 0))
    env.state = WarehouseState((0, 2), has_item=True, battery=1, steps=7)
    observation, reward, terminated, truncated, _ = env.step("DROP")
    assert (reward, terminated, truncated) == (pytest.approx(9.9), True, True)
    assert (observation["steps"], observation["battery"]) == (8, 0)


@pytest.mark.parametrize("cell", [(0, 0), (-1, 5)])
def test_a_step_of_a_robot_put_on_a_wall_raises(cell: tuple[int, int]) -> None:
    env = WarehouseEnv()
    env.step("E")
    env.state.robot_pos = cell
    for _ in range(2):
        with pytest.raises(LayoutError, match=f"row {cell[0]}, column {cell[1]} is"):
            env.step("E")
    assert (env.state.steps, env.state.battery) == (1, 199)
    env.state.robot_pos = (1, 1)
    assert env.step("E")[0]["robot_pos"] == (1, 2)


# Errors, which leave the environment unchanged.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"grid": []}, "the layout is empty"),
        ({"grid": ["...", "..x"]}, r"row 1, column 2: 'x' is not .*: # \(wall\), \. \("),
        ({"start_pos": (0, 0)}, "start_pos row 0, column 0 is wall"),
        ({"start_pos": (7, 1)}, r"start_pos row 7, column 1 is off .*\(rows 0..6, columns 0..11"),
    ],
)
def test_an_invalid_value_raises(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        WarehouseEnv(**arguments)


@pytest.mark.parametrize("action", [None, 1.5, b"N"])
def test_an_action_of_another_type_raises_and_changes_nothing(action: Any) -> None:
    env = WarehouseEnv()
    env.step("E")
    before = everything(env)
    allowed = "allowed: one of N, E, S, W, WAIT, PICK, DROP or its index"
    with pytest.raises(TypeError, match=allowed):
        env.step(action)
    assert everything(env) == before
    assert env.step("E")[0]["robot_pos"] == (1, 3)


def test_an_error_of_the_motion_leaves_the_state_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    env = WarehouseEnv()
    env.step("E")
    before = everything(env)
    monkeypatch.setattr(env.motion, "advance", Mock(side_effect=ArithmeticError("broken down")))
    with pytest.raises(ArithmeticError):
        env.step("E")
    assert everything(env) == before


# Random choices of a reset.

STATIONED = ["#######", "#P.P..#", "#.#.#.#", "#..D..#", "#######"]


def test_a_reset_may_draw_the_start_alone() -> None:
    env = WarehouseEnv(STATIONED, None)
    layout, starts = env.layout, set()
    for seed in range(60):
        starts.add(env.reset("start", seed=seed)["robot_pos"])
        assert env.layout is layout
    empty = {(row, col) for row in range(5) for col in range(7) if STATIONED[row][col] == "."}
    assert starts == empty
    assert env.reset()["robot_pos"] == env.start_pos


def test_a_reset_may_draw_the_stations_alone() -> None:
    env = WarehouseEnv(STATIONED, (3, 5))
    everything = WarehouseEnv(STATIONED, (3, 5))
    for seed in range(5):
        assert env.reset("stations", seed=seed)["robot_pos"] == (3, 5)
        everything.reset(True, seed=seed)
        assert env.grid == everything.grid != STATIONED


def test_a_start_is_the_default_one_where_all_cells_are_stations() -> None:
    assert WarehouseEnv(["PD"], (0, 1)).reset("start", seed=1)["robot_pos"] == (0, 1)


def test_an_unknown_word_for_what_to_draw_is_an_error() -> None:
    env = WarehouseEnv()
    before = env.observe()
    with pytest.raises(ValueError, match="randomize is 'all'; allowed: False, True, 'stations'"):
        env.reset("all")
    assert env.observe() == before


def test_the_repr_names_the_present_stations_and_the_backend() -> None:
    env = WarehouseEnv(["P..D"], None, backend=GridMotion)
    assert repr(env) == "<WarehouseEnv 1 x 4, pickup (0, 0), dropoff (0, 3), backend 'GridMotion'>"
    env.reset_to(Layout([".."]))
    assert repr(env) == "<WarehouseEnv 1 x 2, no pickups, no dropoffs, backend 'GridMotion'>"
