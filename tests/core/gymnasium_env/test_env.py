"""``Warehouse-v0`` as Gymnasium's own checks, wrappers and vector environments see it.

Every warning is an error here (``pyproject.toml``), those of Gymnasium's checkers too. All versions
of Gymnasium from 1.0 on run every test; what 1.0 does not know, such as modes of autoreset, it
is not asked for.
"""

import copy
import hashlib
import inspect
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.utils.passive_env_checker import env_render_passive_checker
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import (
    FlattenObservation,
    RecordEpisodeStatistics,
    RecordVideo,
    TimeLimit,
)
from gymnasium.wrappers.vector import RecordEpisodeStatistics as RecordBatchStatistics

from warehouse_core import DEFAULT_LAYOUT, Layout, LayoutError, WarehouseEnv, random_layout
from warehouse_core.errors import NoDisplayError
from warehouse_core.gymnasium_env import ID, WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env import env as gymnasium_env_module
from warehouse_core.gymnasium_env.spaces import FORMS, RENDER_FPS
from warehouse_core.gymnasium_env.vector import WarehouseVectorEnv
from warehouse_core.motion.grid import GridMotion
from warehouse_core.render.observation_image import ObservationImage
from warehouse_core.task.encoding import encode, vector
from warehouse_core.task.rules import useful_actions

NAME = f"warehouse_core.gymnasium_env:{ID}"
"""As a program names it that imports nothing but Gymnasium."""

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
CORRIDOR = Layout(["P....D"])
TWO_CELLS = Layout(["#.#", "#.#"])

HAS_MODES = hasattr(gymnasium.vector, "AutoresetMode")
MODES = ["NextStep", "SameStep", "Disabled"] if HAS_MODES else ["NextStep"]

over_forms = pytest.mark.parametrize("form", FORMS)
over_modes = pytest.mark.parametrize("mode", MODES)
over_backends = pytest.mark.parametrize("backend", ["grid", "physics"])
allow_fork = pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
"""Python 3.12 warns of every fork in a process in which NumPy has started its threads."""


def make(**settings: Any) -> Any:
    return gymnasium.make(NAME, **settings)


def plain(**settings: Any) -> WarehouseGymnasiumEnv:
    return make(**settings).unwrapped


def make_vec(count: int, mode: str, **settings: Any) -> Any:
    return gymnasium.make_vec(NAME, count, "vector_entry_point", autoreset_mode=mode, **settings)


def make_sync(count: int, mode: str, **settings: Any) -> SyncVectorEnv:
    modes = {"autoreset_mode": mode} if HAS_MODES else {}
    return SyncVectorEnv([partial(make, **settings)] * count, **modes)


def same(value: Any, other: Any) -> bool:
    """Say whether two observations, or parts of info, are equal, dtypes of arrays included."""
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(same(value[key], other[key]) for key in value)
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return len(value) == len(other) and all(map(same, value, other))
    if isinstance(value, np.ndarray):
        return value.dtype == other.dtype and np.array_equal(value, other)
    return type(value) is type(other) and bool(value == other)


def walk(env: Any, seed: int, steps: int = 40) -> list[Any]:
    """Return everything that a random walk gives, which begins anew whenever it ends."""
    stream = np.random.default_rng(seed)
    told: list[Any] = [env.reset(seed=seed)]
    for action in stream.integers(7, size=steps).tolist():
        told.append(env.step(action))
        if told[-1][2] or told[-1][3]:
            told.append(env.reset())
    return told


# Gymnasium's checks.


@over_backends
@over_forms
@pytest.mark.parametrize("render_mode", [None, "rgb_array", "ansi"])
def test_gymnasium_finds_nothing_to_complain_of(
    backend: str, form: str, render_mode: str | None
) -> None:
    env = plain(backend=backend, observation=form, render_mode=render_mode)
    # It would try all render modes, and one of them needs a display: test_window_gymnasium.py.
    check_env(env, skip_render_check=True)
    if render_mode is not None:
        env_render_passive_checker(env)
    env.close()


@over_forms
@pytest.mark.parametrize(
    "layout", [CORRIDOR, Layout(["P", ".", "D"]), TWO_CELLS, Layout(["..", ".."])], ids=str
)
def test_gymnasium_finds_nothing_in_odd_layouts_either(form: str, layout: Layout) -> None:
    for radius, randomize in ((0, False), (1, True)):
        check_env(
            plain(layout=layout, observation=form, view_radius=radius, randomize=randomize),
            skip_render_check=True,
        )


@over_forms
@pytest.mark.parametrize("layout", [CORRIDOR, ROOM, random_layout(9, 6, 0.2, seed=4)], ids=str)
def test_every_observation_is_in_its_space_up_to_its_limits(form: str, layout: Layout) -> None:
    limits = {"max_steps": 9, "battery": 12, "view_radius": 1}
    env = make(layout=layout, observation=form, **limits)
    for observation, *_ in walk(env, seed=1, steps=200):
        assert observation in env.observation_space
    space = env.observation_space
    if form == "vector":
        seen = np.stack([observation for observation, *_ in walk(env, seed=1, steps=2000)])
        corners = space.low < space.high
        assert (seen.min(axis=0) == space.low)[-3:].tolist() == [True, False, True]
        assert (seen.max(axis=0) == space.high)[-3:].tolist() == [True] * 3
        assert corners.all()


def test_the_spaces_are_what_is_promised() -> None:
    spaces = {form: make(observation=form, view_radius=1).observation_space for form in FORMS}
    flat = spaces["dict"]
    assert {key: space.shape for key, space in flat.items()} == {
        "local_grid": (9,),
        "robot_pos": (2,),
        "has_item": (),
        "battery": (1,),
        "steps": (1,),
        "pickup_pos": (2,),
        "dropoff_pos": (2,),
    }
    assert (flat["robot_pos"].low.tolist(), flat["robot_pos"].high.tolist()) == ([0, 0], [6, 11])
    assert flat["pickup_pos"].low.tolist() == [-1, -1]
    assert flat["steps"].high.tolist() == flat["battery"].high.tolist() == [200]
    assert spaces["vector"].shape == (3 * 9 + 11,)
    assert spaces["image"].shape == (64, 96, 3)
    assert make().action_space == gymnasium.spaces.Discrete(7)


def test_the_name_is_found_by_a_program_that_imports_gymnasium_alone() -> None:
    program = f"""
import gymnasium
env = gymnasium.make("{NAME}", layout=["P.D"])
assert gymnasium.spec("{ID}").entry_point == "{NAME.split(":")[0]}:WarehouseGymnasiumEnv"
print(env.reset(seed=0)[0]["robot_pos"].tolist()[0])
"""
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True)
    assert (done.stdout.strip(), done.stderr) == (b"0", b"")


def test_an_environment_can_be_made_again_from_json() -> None:
    settings = {"layout": list(ROOM.rows), "start_pos": (2, 2), "randomize": False}
    env = make(**settings, observation="vector", max_steps=8, view_radius=1)
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.spec.kwargs["layout"] == list(ROOM.rows)
    assert same(tuple(walk(env, 3)), tuple(walk(again, 3)))
    assert again.unwrapped.warehouse.start_pos == (2, 2)


def test_a_layout_is_given_as_itself_as_rows_or_as_text() -> None:
    for layout in (ROOM, ROOM.rows, list(ROOM.rows), str(ROOM), f"\n    {ROOM.rows[0]}\n    #P.D#"):
        env = plain(layout=layout, randomize=False)
        assert env.warehouse.layout.rows[:2] == ROOM.rows[:2]
    assert plain(randomize=False).warehouse.layout is DEFAULT_LAYOUT


# One environment.


@over_forms
def test_observations_are_those_of_the_chapters_environment(form: str) -> None:
    env = plain(layout=ROOM, observation=form, max_steps=12)
    image = ObservationImage(4, 5, battery=200, max_steps=12)
    of = {"dict": lambda arrays: arrays, "vector": vector, "image": image.paint}[form]
    for seed in range(5):
        told, _ = env.reset(seed=seed)
        start = env.warehouse.state.robot_pos
        twin = WarehouseEnv(env.warehouse.layout, start, max_steps=12)
        assert same(told, of(encode(twin.observe())))
        over = False
        while not over:
            action = (PICK, WEST, NORTH, DROP, EAST)[twin.state.steps % 5]
            told, *verdict, _ = env.step(action)
            expected, *other_verdict, _ = twin.step(action)
            assert same(told, of(encode(expected)))
            assert same(tuple(verdict), tuple(other_verdict))
            assert [type(value) for value in verdict] == [float, bool, bool]
            over = verdict[1] or verdict[2]


def test_the_same_seed_gives_the_same_episodes_whatever_came_before() -> None:
    env = plain(layout=random_layout(9, 9, 0.2, seed=0))
    first, starts = walk(env, seed=6), [env.reset()[0] for _ in range(4)]
    assert same(tuple(walk(env, seed=6)), tuple(first))
    assert len({str(start) for start in starts}) > 1
    assert not same(tuple(walk(env, seed=7)), tuple(first))


def test_stations_and_start_are_drawn_only_if_asked_for() -> None:
    fixed = plain(randomize=False)
    starts = [fixed.reset(seed=seed)[0] for seed in (0, 1)]
    assert same(*starts)
    assert starts[0]["pickup_pos"].tolist() == [1, 3]
    drawn = [plain().reset(seed=seed)[0] for seed in range(6)]
    for key in ("pickup_pos", "dropoff_pos", "robot_pos"):
        assert len({tuple(start[key]) for start in drawn}) > 2


def test_both_backends_tell_the_same_story() -> None:
    grid, physics = (
        walk(plain(layout=ROOM, backend=backend, max_steps=30), seed=1)
        for backend in ("grid", "physics")
    )
    for one, other in zip(grid, physics, strict=True):
        assert same(one[:-1], other[:-1])
        assert same(one[-1]["action_mask"], other[-1]["action_mask"])


@over_backends
def test_info_tells_what_the_motion_did(backend: str) -> None:
    env = plain(layout=ROOM, backend=backend, randomize=False, max_steps=50)
    _, info = env.reset(seed=0)
    assert set(info) == {"action_mask"}
    for action in (WEST, NORTH, EAST, WAIT, PICK, SOUTH):
        *_, info = env.step(action)
        assert set(info) == {"motion", "action_mask"}
        motion, last = info["motion"], env.warehouse.last_motion
        assert motion == last
        assert not np.shares_memory(motion.path, last.path)
        expected = motion.path.copy()
        motion.path[:] = 0
        assert np.array_equal(env.warehouse.last_motion.path, expected)
    assert env.step(NORTH)[-1]["motion"] == env.warehouse.last_motion


class Gambling(GridMotion):
    """A grid that keeps the seeds of whatever chance it might know."""

    seeds: ClassVar[list[int | None]] = []

    def reset(self, layout: Layout, cells: Any, seed: int | None) -> None:
        super().reset(layout, cells, seed)
        self.seeds.append(seed)


@pytest.mark.parametrize("randomize", [False, True], ids=["as given", "drawn"])
def test_the_chance_of_a_motion_comes_from_the_seed_too(randomize: bool) -> None:
    env = plain(backend=Gambling, randomize=randomize)
    Gambling.seeds.clear()
    for seed in (1, None, 1, None, 2):
        env.reset(seed=seed)
    first, second, *again, other = Gambling.seeds
    assert again == [first, second]
    assert len({first, second, other}) == 3
    assert all(type(seed) is int for seed in (first, second, other))


def test_the_mask_says_which_actions_do_something_now() -> None:
    shop = Layout(["P.", "#D"])
    env = plain(layout=shop, start_pos=(0, 0), randomize=False)
    _, info = env.reset()
    assert info["action_mask"].dtype == np.int8
    told = [info["action_mask"].tolist()]
    for action in (PICK, EAST, SOUTH):
        *_, info = env.step(action)
        told.append(info["action_mask"].tolist())
    assert told == [
        [0, 1, 0, 0, 1, 1, 0],
        [0, 1, 0, 0, 1, 0, 0],
        [0, 0, 1, 1, 1, 0, 0],
        [1, 0, 0, 0, 1, 0, 1],
    ]


@over_backends
def test_the_mask_is_fresh_and_the_same_from_all_who_give_it(backend: str) -> None:
    env = plain(layout=random_layout(6, 6, 0.3, seed=1), backend=backend, max_steps=15)
    stream = np.random.default_rng(0)
    for episode in range(4):
        _, info = env.reset(seed=episode)
        over = False
        while not over:
            layout, state = env.warehouse.layout, env.warehouse.state
            row, col = state.robot_pos
            tile, sides = layout.rows[row][col], layout.open_sides((row, col))
            expected = list(useful_actions(sides, tile, state.has_item))
            for mask in (info["action_mask"], env.action_masks(), env.action_masks()):
                assert mask.tolist() == expected
                mask[:] = 3
            *_, terminated, truncated, info = env.step(int(stream.integers(7)))
            over = terminated or truncated


def spoil(data: Any) -> None:
    """Overwrite every array in what an environment has returned."""
    if isinstance(data, np.ndarray):
        data[...] = 77
    elif isinstance(data, (dict, tuple)):
        for value in data.values() if isinstance(data, dict) else data:
            spoil(value)


@over_forms
@over_backends
def test_nothing_that_was_returned_changes_later(form: str, backend: str) -> None:
    env = plain(layout=ROOM, observation=form, backend=backend, max_steps=9)
    kept: list[Any] = [env.reset(seed=3)]
    records = [pickle.dumps(kept[0])]
    for action in np.random.default_rng(5).integers(7, size=30).tolist():
        kept.append(env.reset() if kept[-1][2:4].count(True) else env.step(action))
        records.append(pickle.dumps(kept[-1]))
    assert all(map(same, kept, map(pickle.loads, records)))


@over_forms
@over_backends
def test_nothing_that_was_returned_is_used_later(form: str, backend: str) -> None:
    env, twin = (plain(layout=ROOM, observation=form, backend=backend) for _ in range(2))
    for seed in range(3):
        told, expected = env.reset(seed=seed), twin.reset(seed=seed)
        for action in (EAST, PICK, SOUTH, WEST, NORTH, EAST, EAST, WEST):
            assert same(told, expected)
            spoil(told)
            spoil(env.action_masks())
            told, expected = env.step(action), twin.step(action)


def test_an_episode_ends_and_then_wants_a_reset() -> None:
    env = plain(layout=ROOM, randomize=False)
    with pytest.raises(ResetNeeded, match=r"step\(\): there has been no reset\(\) yet"):
        env.step(EAST)
    env.reset()
    for action in (PICK, EAST, EAST):
        assert env.step(action)[2:4] == (False, False)
    assert env.step(DROP)[1:4] == (pytest.approx(9.9), True, False)
    before = pickle.dumps(env)
    for _ in range(2):
        with pytest.raises(ResetNeeded, match="the episode has ended"):
            env.step(EAST)
    assert pickle.dumps(env) == before
    env.reset()
    assert env.step(EAST)[0]["steps"].tolist() == [1]


@pytest.mark.parametrize("limit", ["max_steps", "battery"])
def test_an_episode_is_cut_off_by_steps_and_by_battery(limit: str) -> None:
    env = plain(**{limit: 2})
    env.reset(seed=0)
    assert [env.step(WAIT)[2:4] for _ in range(2)] == [(False, False), (False, True)]
    with pytest.raises(ResetNeeded):
        env.step(WAIT)


@pytest.mark.parametrize(
    ("action", "error", "message"),
    [
        (7, ValueError, r"action 7 is out of range; allowed: 0\.\.6"),
        (-1, ValueError, "action -1 is out of range"),
        (np.int64(99), ValueError, "action 99"),
        (1.0, TypeError, r"action 1\.0 is float; allowed: an integer 0\.\.6"),
        (float("nan"), TypeError, "action nan"),
        ("N", TypeError, "action 'N' is str"),
        (None, TypeError, "action None"),
        (np.array([1]), TypeError, r"action array\(\[1\]\)"),
        ([1], TypeError, r"action \[1\]"),
    ],
    ids=repr,
)
def test_an_action_that_is_none_changes_nothing(action: Any, error: type, message: str) -> None:
    env = plain()
    env.reset(seed=0)
    before = pickle.dumps(env)
    with pytest.raises(error, match=message):
        env.step(action)
    assert pickle.dumps(env) == before


@pytest.mark.parametrize("kind", [int, np.int8, np.uint64, np.array])
def test_an_action_is_an_integer_of_any_kind(kind: Callable[[int], Any]) -> None:
    env = plain(layout=ROOM, randomize=False)
    env.reset()
    assert env.step(kind(EAST))[0]["robot_pos"].tolist() == [1, 2]


# Options.


def test_options_are_for_one_episode_alone() -> None:
    other = Layout(["#####", "#...#", "#DP.#", "#####"])
    env = plain(layout=ROOM, start_pos=(2, 3), randomize=False)
    usual, _ = env.reset()
    assert usual["robot_pos"].tolist() == [2, 3]
    told, _ = env.reset(options={"start_pos": [1, 2]})
    assert told["robot_pos"].tolist() == [1, 2]
    told, info = env.reset(options={"layout": other.rows})
    assert told["pickup_pos"].tolist() == [2, 2]
    assert info["action_mask"].tolist() == [1, 0, 0, 1, 1, 0, 0]
    drawn = [env.reset(options={"randomize": True})[0] for _ in range(9)]
    assert len({tuple(each["robot_pos"]) for each in drawn}) > 2
    assert same(env.reset()[0], usual)
    assert same(env.reset(options={})[0], usual)
    env = plain(layout=ROOM)
    told, _ = env.reset(seed=1, options={"randomize": False})
    assert told["pickup_pos"].tolist() == [1, 1]
    told, _ = env.reset(seed=1, options={"start_pos": (2, 2)})
    assert told["robot_pos"].tolist() == [2, 2]
    assert same(told["pickup_pos"], env.reset(seed=1)[0]["pickup_pos"])


def test_a_layout_for_one_episode_has_walls_of_its_own() -> None:
    """What was worked out of the layout before must be forgotten, masks and windows too."""
    walled = Layout(["#####", "#P#D#", "#...#", "#####"])
    env = plain(layout=ROOM, randomize=False)
    env.reset()
    env.step(EAST)
    told, info = env.reset(options={"layout": walled})
    assert info["action_mask"].tolist() == [0, 0, 1, 0, 1, 1, 0]
    assert told["local_grid"].reshape(5, 5)[2].tolist() == [1, 1, 4, 1, 3]
    assert env.step(EAST)[0]["robot_pos"].tolist() == [1, 1]
    _, info = env.reset()
    assert info["action_mask"].tolist() == [0, 1, 1, 0, 1, 1, 0]


def test_the_usual_start_is_that_of_the_layout_of_the_episode() -> None:
    shut = Layout(["#####", "###D#", "#..P#", "#####"])
    told, _ = plain(layout=ROOM, randomize=False).reset(options={"layout": shut})
    assert told["robot_pos"].tolist() == [1, 3]
    with pytest.raises(LayoutError, match="start_pos row 1, column 2 is wall"):
        plain(layout=ROOM, start_pos=(1, 2), randomize=False).reset(options={"layout": shut})
    two = plain(layout=["..#"])
    for start_pos, expected in ((None, [0, 1]), ((0, 2), [0, 2])):
        told, _ = two.reset(options={"layout": ["#.."], "start_pos": start_pos})
        assert told["robot_pos"].tolist() == expected


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({3: 1, "a": 2}, ValueError, "unknown options: 'a', 3; allowed: layout"),
        (["layout"], TypeError, r"options is \['layout'\]; it must be a dict"),
        ({"randomize": "no"}, TypeError, "randomize is 'no'; it must be True or False"),
        ({"sed": 1, "a": 2}, ValueError, "unknown options: 'a', 'sed'; allowed: layout, ra"),
        ({"layout": CORRIDOR}, LayoutError, "has 1 x 6 cells; this environment was made for 4 x 5"),
        ({"layout": ["##", "#"]}, LayoutError, "row 1 has 1 columns"),
        ({"layout": 5}, TypeError, "int"),
        ({"layout": ["#####"] * 3 + ["###.#"]}, LayoutError, "two open cells"),
        ({"start_pos": (0, 0)}, LayoutError, "start_pos row 0, column 0 is wall"),
        ({"start_pos": (9, 9)}, LayoutError, "row 9, column 9 is off the grid"),
        ({"start_pos": 3}, TypeError, "start_pos is 3; it must be two integers"),
        ({"start_pos": (1.5, 1)}, TypeError, r"start_pos is \(1.5, 1\)"),
        ({"start_pos": (1, 1), "layout": ["###.#"] * 4}, LayoutError, "row 1, column 1 is wall"),
    ],
    ids=repr,
)
def test_options_that_cannot_be_used_change_nothing(
    options: dict[str, Any], error: type, message: str
) -> None:
    env = plain(layout=ROOM)
    env.reset(seed=4)
    env.step(EAST)
    before = pickle.dumps(env)
    with pytest.raises(error, match=message):
        env.reset(seed=5, options=options)
    assert pickle.dumps(env) == before


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        (
            {"observation": "text"},
            ValueError,
            "observation is 'text'; allowed: dict, vector, image",
        ),
        ({"observation": None}, ValueError, "observation is None"),
        ({"backend": "boat"}, ValueError, "no backend is called 'boat'"),
        ({"layout": ["#"]}, LayoutError, "no open cell"),
        ({"layout": ["#."]}, LayoutError, "two open cells"),
        ({"layout": [".x."]}, LayoutError, "row 0, column 1: 'x' is not a tile"),
        ({"layout": 3}, TypeError, "int"),
        ({"start_pos": (0, 0)}, LayoutError, "row 0, column 0 is wall"),
        ({"start_pos": (1.5, 1)}, TypeError, "start_pos .*must be two integers"),
        ({"max_steps": 0}, ValueError, "max_steps is 0"),
        ({"battery": 1.5}, TypeError, "battery is 1.5"),
        ({"view_radius": -1}, ValueError, "view_radius is -1"),
        ({"tile_pixels": 0}, ValueError, "tile_pixels is 0; it must be at least 2"),
        (
            {"render_mode": "video"},
            ValueError,
            "render_mode is 'video'; allowed: None,.* rgb_array",
        ),
    ],
    ids=repr,
)
@pytest.mark.parametrize("kind", [WarehouseGymnasiumEnv, WarehouseVectorEnv])
def test_an_environment_that_could_not_work_is_not_made(
    kind: Any, settings: dict[str, Any], error: type, message: str
) -> None:
    with pytest.raises(error, match=message):
        kind(**settings)


# Pictures.


def test_a_picture_shows_the_layout_and_where_the_robot_is() -> None:
    env = plain(layout=ROOM, randomize=False, render_mode="rgb_array", tile_pixels=10)
    env.reset()
    before = env.render()
    assert (before.shape, before.dtype) == ((40, 50, 3), np.uint8)
    env.step(EAST)
    after = env.render()
    cells = (before != after).reshape(4, 10, 5, 10, 3).any(axis=(1, 3, 4))
    assert np.argwhere(cells).tolist() == [[1, 1], [1, 2]]
    assert not np.shares_memory(after, env.render())
    env.reset(options={"layout": Layout(["#####", "#.PD#", "#...#", "#####"])})
    assert (env.render() != before).any()


def test_a_tile_is_as_large_as_it_is_told_or_as_fits() -> None:
    for layout, tile_pixels, expected in (
        (ROOM, None, (160, 200, 3)),
        (ROOM, 3, (12, 15, 3)),
        (random_layout(50, 20, 0.1, seed=0), None, (1000, 400, 3)),
    ):
        env = plain(layout=layout, render_mode="rgb_array", tile_pixels=tile_pixels)
        env.reset(seed=0)
        assert env.render().shape == expected


def test_text_is_that_of_the_chapters_environment() -> None:
    env = plain(render_mode="ansi")
    for seed in range(3):
        env.reset(seed=seed)
        assert env.render() == env.warehouse.render()
        assert env.render().count("R") == 1


def test_rendering_without_a_mode_is_warned_of() -> None:
    env = plain()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="needs a render_mode, given to gymnasium.make"):
        assert env.render() is None
    batch = WarehouseVectorEnv(2)
    batch.reset(seed=0)
    with pytest.warns(UserWarning, match="given to gymnasium.make_vec"):
        assert batch.render() is None


class PaperWindow:
    """Stands for a window, and keeps what it is told to show."""

    opened: "list[PaperWindow]"

    def __init__(self, title: str) -> None:
        self.title, self.closed = title, 0
        self.shown: list[tuple[Any, float]] = []
        self.opened.append(self)

    def show(self, picture: Any, fps: float) -> None:
        self.shown.append((picture, fps))

    def close(self) -> None:
        self.closed += 1


def test_a_window_is_shown_every_reset_and_step(monkeypatch: pytest.MonkeyPatch) -> None:
    PaperWindow.opened = []
    monkeypatch.setattr(gymnasium_env_module, "PictureWindow", PaperWindow)
    env, still = (plain(render_mode=mode) for mode in ("human", "rgb_array"))
    assert not PaperWindow.opened
    for each in (env, still):
        each.reset(seed=0)
    expected = [still.render()]
    for action in (EAST, SOUTH, WEST):
        env.step(action), still.step(action)
        expected.append(still.render())
    assert env.render() is None
    (window,) = PaperWindow.opened
    assert window.title == "Warehouse"
    assert [fps for _, fps in window.shown] == [RENDER_FPS] * 4
    assert same(tuple(picture for picture, _ in window.shown), tuple(expected))
    env.close()
    env.close()
    assert window.closed == 1


def test_a_window_where_there_is_no_display_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_core.render.window.has_display", lambda: False)
    env = plain(render_mode="human")
    with pytest.raises(NoDisplayError, match='render_mode="human" needs a window'):
        env.reset()
    env.close()


# Copies.


@over_forms
def test_a_copy_and_a_pickle_go_on_as_the_original_does(form: str) -> None:
    env = plain(layout=ROOM, observation=form, render_mode="rgb_array", max_steps=6)
    walk(env, seed=3, steps=16)
    copies = [env, copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    told = []
    for each in copies:
        told.append([each.step(EAST), each.render(), each.reset(), each.step(EAST)])
    assert all(same(tuple(told[0]), tuple(other)) for other in told[1:])


def test_a_copy_on_the_physics_backend_goes_on_too() -> None:
    env = plain(layout=ROOM, backend="physics", randomize=False)
    env.reset(seed=0)
    env.step(EAST)
    twin = copy.deepcopy(env)
    assert same(env.step(SOUTH)[0], twin.step(SOUTH)[0])


# Wrappers.


def test_a_video_is_recorded(tmp_path: Path) -> None:
    import imageio_ffmpeg

    folder = tmp_path / "videos"
    env = RecordVideo(
        make(render_mode="rgb_array", max_steps=12, tile_pixels=16),
        str(folder),
        episode_trigger=lambda episode: episode == 0,
    )
    env.reset(seed=0)
    steps = 0
    over = False
    while not over:
        *_, terminated, truncated, _ = env.step(WAIT)
        over, steps = terminated or truncated, steps + 1
    env.reset()
    env.close()
    (video,) = folder.glob("*.mp4")
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(video))
    assert frames == steps + 1 == 13
    assert seconds == pytest.approx(13 / RENDER_FPS, abs=0.2)


def test_wrappers_wrap() -> None:
    flat = FlattenObservation(make(view_radius=1))
    # 6 codes are no one-hots: 9 + 2 + one-hot 2 + 1 + 1 + 2 + 2.
    assert flat.observation_space.shape == (19,)
    for observation, *_ in walk(flat, seed=0):
        assert observation in flat.observation_space
    counted = RecordEpisodeStatistics(make(max_steps=4))
    ends = [told[-1]["episode"] for told in walk(counted, seed=0) if "episode" in told[-1]]
    assert ends
    assert {int(end["l"]) for end in ends} == {4}
    short = TimeLimit(make(), max_episode_steps=3)
    short.reset(seed=0)
    assert [short.step(WAIT)[3] for _ in range(3)] == [False, False, True]
    short = make(max_episode_steps=3)
    short.reset(seed=0)
    assert [short.step(WAIT)[3] for _ in range(3)] == [False, False, True]


@over_modes
def test_statistics_of_a_batch_are_recorded(mode: str) -> None:
    env = RecordBatchStatistics(make_vec(3, mode, max_steps=4))
    env.reset(seed=0)
    rewards = []
    for _ in range(4):
        _, reward, _, truncated, info = env.step(np.full(3, NORTH))
        rewards.append(reward)
    assert truncated.all()
    assert info["episode"]["r"] == pytest.approx(np.sum(rewards, axis=0))
    assert info["episode"]["l"].tolist() == [4, 4, 4]


# Batches.


def assert_infos_alike(found: dict[str, Any], expected: dict[str, Any]) -> None:
    """Compare what is said of the rows that it is about; motions are told in another form."""
    for key in sorted({*found, *expected} - {"motion", "_motion"}):
        if key.startswith("_"):
            assert found[key].dtype == expected[key].dtype == bool
            assert found[key].tolist() == expected[key].tolist(), key
            continue
        rows = np.flatnonzero(expected[f"_{key}"])
        if key == "final_info":
            assert_infos_alike(found[key], expected[key])
        elif key == "final_obs":
            assert found[key].dtype == expected[key].dtype == object
            for one, other in zip(found[key], expected[key], strict=True):
                assert (one is None) == (other is None)
                assert one is None or equal_in_value(one, other)
        else:
            assert found[key].dtype == expected[key].dtype
            assert found[key].shape == expected[key].shape
            assert np.array_equal(found[key][rows], expected[key][rows]), key
    if "_motion" not in found:
        assert "_motion" not in expected
        return
    count = len(found["_motion"])
    rows = np.flatnonzero(found["_motion"])
    nothing = np.zeros(count, bool)
    assert rows.tolist() == np.flatnonzero(expected.get("_motion", nothing)).tolist()
    for row in rows:
        for key, values in found["motion"].items():
            if not key.startswith("_"):
                assert values[row] == getattr(expected["motion"][row], key)


def equal_in_value(value: Any, other: Any) -> bool:
    """Compare observations; a number taken out of an array is NumPy's, one of Python is not."""
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(
            equal_in_value(value[key], other[key]) for key in value
        )
    return np.array_equal(value, other) and getattr(value, "shape", ()) == np.shape(other)


@over_modes
@over_forms
@pytest.mark.parametrize("randomize", [False, True], ids=["as given", "drawn"])
def test_a_batch_is_gymnasiums_own_bit_for_bit(mode: str, form: str, randomize: bool) -> None:
    count = 5
    settings = {"layout": ROOM, "observation": form, "randomize": randomize, "max_steps": 14}
    batch, sync = (kind(count, mode, **settings) for kind in (make_vec, make_sync))
    for name in ("observation_space", "single_observation_space", "action_space"):
        assert getattr(batch, name) == getattr(sync, name)
    assert batch.single_action_space == sync.single_action_space
    if HAS_MODES:
        assert batch.metadata["autoreset_mode"] is sync.metadata["autoreset_mode"]

    def reset(**given: Any) -> None:
        # Gymnasium takes the mask out of its options, so each is given its own.
        told = [each.reset(**copy.deepcopy(given)) for each in (batch, sync)]
        assert same(told[0][0], told[1][0])
        assert told[0][0] in batch.observation_space
        assert_infos_alike(told[0][1], told[1][1])

    reset(seed=21)
    stream, ends = np.random.default_rng(1), 0
    ended = np.zeros(count, bool)
    for number in range(160):
        if mode == "Disabled" and ended.any():
            reset(options={"reset_mask": ended})
        elif number % 40 == 39:
            # From here on the rows are out of step.
            given = {"options": {"reset_mask": np.arange(count) < 2}} if HAS_MODES else {}
            reset(seed=[3, None, 4, None, 5], **given)
        # So many of PICK and DROP that some are in the right place.
        actions = stream.choice([0, 1, 2, 3, 4, 5, 5, 6, 6], size=count)
        told = [each.step(actions) for each in (batch, sync)]
        for one, other in zip(*(each[:4] for each in told), strict=True):
            assert same(one, other)
        assert told[0][0] in batch.observation_space
        assert_infos_alike(told[0][4], told[1][4])
        ended = told[0][2] | told[0][3]
        ends += int(told[0][2].sum())
    assert ends
    batch.close()
    sync.close()


@over_modes
def test_a_batch_of_physics_does_what_each_robot_would_do_by_itself(mode: str) -> None:
    settings = {"layout": ROOM, "backend": "physics", "max_steps": 9}
    batch, sync = (kind(3, mode, **settings) for kind in (make_vec, make_sync))
    with closing(batch), closing(sync):
        assert same(*(each.reset(seed=2)[0] for each in (batch, sync)))
        for actions in np.random.default_rng(4).integers(7, size=(24, 3)):
            told = [each.step(actions) for each in (batch, sync)]
            assert same(*(each[:4] for each in told))
            rows = np.flatnonzero(told[0][4]["_motion"])
            for row in rows:
                motion = told[1][4]["motion"][row]
                assert told[0][4]["motion"]["blocked"][row] == motion.blocked
                assert told[0][4]["motion"]["seconds"][row] == pytest.approx(motion.seconds)
            ended = told[0][2] | told[0][3]
            if mode == "Disabled" and ended.any():
                starts = [each.reset(options={"reset_mask": ended})[0] for each in (batch, sync)]
                assert same(*starts)


@allow_fork
@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_processes_of_their_own_give_the_same(context: str) -> None:
    settings = {"layout": list(ROOM.rows), "max_steps": 5}
    apart = AsyncVectorEnv([partial(make, **settings)] * 2, context=context)
    batch = WarehouseVectorEnv(2, **settings)
    with closing(apart):
        assert same(apart.reset(seed=4)[0], batch.reset(seed=4)[0])
        for actions in np.random.default_rng(1).integers(7, size=(12, 2)):
            *told, info = apart.step(actions)
            *expected, expected_info = batch.step(actions)
            assert same(tuple(told), tuple(expected))
            assert_infos_alike(expected_info, info)


@allow_fork
def test_all_three_ways_to_make_a_batch_give_the_same() -> None:
    told = []
    for way in ("sync", "async", "vector_entry_point", None):
        made = gymnasium.make_vec(NAME, 3, vectorization_mode=way, layout=ROOM, max_steps=6)
        with closing(made) as env:
            record = [env.reset(seed=2)[0]]
            for actions in np.random.default_rng(1).integers(7, size=(10, 3)):
                record.append(env.step(actions)[:4])
            is_ours = type(env.unwrapped) is WarehouseVectorEnv
        assert is_ours == (way in ("vector_entry_point", None))
        told.append(tuple(record))
    assert all(same(other, told[0]) for other in told[1:])


@over_forms
def test_layouts_of_different_sizes_share_one_space(form: str) -> None:
    layouts = [CORRIDOR, ROOM, random_layout(7, 4, 0.2, seed=0), ROOM]
    batch = WarehouseVectorEnv(4, layouts, observation=form, render_mode="rgb_array", max_steps=9)
    extent = WarehouseVectorEnv(1, ["." * 6] * 7, observation=form, max_steps=9)
    assert batch.single_observation_space == extent.single_observation_space
    observation, _ = batch.reset(seed=0)
    for actions in np.random.default_rng(0).integers(7, size=(30, 4)):
        assert observation in batch.observation_space
        observation, *_ = batch.step(actions)
    sizes = [picture.shape for picture in batch.render()]
    pixels = sizes[0][0]
    assert sizes == [(each.height * pixels, each.width * pixels, 3) for each in layouts]


def test_a_picture_of_each_row_is_that_of_the_row_alone() -> None:
    batch = WarehouseVectorEnv(3, ROOM, render_mode="rgb_array")
    with pytest.raises(ResetNeeded, match=r"needs a reset\(\) before it"):
        batch.render()
    batch.reset(seed=5)
    pictures = batch.render()
    assert type(pictures) is tuple
    for row, picture in enumerate(pictures):
        env = plain(layout=ROOM, render_mode="rgb_array")
        env.reset(seed=5 + row)
        assert same(picture, env.render())


def test_a_batch_is_copied_and_pickled() -> None:
    for form in FORMS:
        batch = WarehouseVectorEnv(3, ROOM, observation=form)
        batch.reset(seed=1)
        others = copy.deepcopy(batch), pickle.loads(pickle.dumps(batch))
        expected = batch.step([EAST, WEST, SOUTH]), batch.reset()
        for other in others:
            assert same((other.step([EAST, WEST, SOUTH]), other.reset()), expected)


def test_the_mask_of_a_batch_is_that_of_its_info() -> None:
    batch = WarehouseVectorEnv(6)
    _, info = batch.reset(seed=0)
    assert same(info["action_mask"], batch.action_masks())
    *_, info = batch.step(np.arange(6))
    assert same(info["action_mask"], batch.action_masks())


def test_what_a_batch_cannot_do_is_said_as_gymnasium_says_it() -> None:
    batch = WarehouseVectorEnv(2, max_steps=1, autoreset_mode="Disabled")
    with pytest.raises(ResetNeeded, match=r"step\(\) needs a reset\(\) before it"):
        batch.step([0, 0])
    with pytest.raises(ResetNeeded, match=r"the first reset\(\) must be of all rows"):
        batch.reset(options={"reset_mask": np.ones(2, bool)})
    batch.reset(seed=0)
    batch.step([WAIT, WAIT])
    before = pickle.dumps(batch)
    with pytest.raises(ResetNeeded, match="2 rows have ended, row 0 first"):
        batch.step([0, 0])
    with pytest.raises(ValueError, match="unknown options: 'layout'; allowed: reset_mask"):
        batch.reset(seed=1, options={"layout": ROOM})
    with pytest.raises(TypeError, match="the mask is"):
        batch.reset(seed=1, options={"reset_mask": [True, False]})
    with pytest.raises(ValueError, match="num_envs is 0"):
        WarehouseVectorEnv(0)
    with pytest.raises(ValueError, match="autoreset_mode is 'Never'"):
        WarehouseVectorEnv(2, autoreset_mode="Never")
    with pytest.raises(ValueError, match="allowed: None, rgb_array"):
        WarehouseVectorEnv(2, render_mode="human")
    with pytest.raises(TypeError, match="the layout of row 1 is list"):
        WarehouseVectorEnv(2, [ROOM, list(ROOM.rows)])
    assert pickle.dumps(batch) == before


def test_both_kinds_take_the_same_arguments_in_the_same_order() -> None:
    single, batch = (
        list(inspect.signature(kind).parameters)
        for kind in (WarehouseGymnasiumEnv, WarehouseVectorEnv)
    )
    assert [name for name in batch if name not in ("num_envs", "autoreset_mode")] == single


# From one process to the next, and from one version of Python to the next.

HASH = "862b4139031d8b56bf9f55e530a148093004e76f59ff9a43b280ae0144e24101"


def trajectory_hash() -> str:
    """Return a digest of fixed episodes, made of whole numbers alone."""
    digest = hashlib.sha256()

    def note(*values: Any) -> None:
        for value in values:
            digest.update(np.ascontiguousarray(value).astype("<i8").tobytes())

    def note_all(observation: Any, info: Any, rewards: Any = 0.0, *flags: Any) -> None:
        note(*(observation[key] for key in sorted(observation)), info["action_mask"], *flags)
        note(np.rint(np.asarray(rewards) * 1e9))

    layout = random_layout(8, 9, 0.25, seed=12)
    env = WarehouseGymnasiumEnv(layout, max_steps=40)
    for observation, *told, info in walk(env, seed=12, steps=150):
        note_all(observation, info, *told)
    batch = WarehouseVectorEnv(4, [layout, ROOM, DEFAULT_LAYOUT, CORRIDOR], max_steps=25)
    note_all(*batch.reset(seed=12))
    for actions in np.random.default_rng(12).integers(7, size=(100, 4)):
        observation, *told, info = batch.step(actions)
        note_all(observation, info, *told)
    return digest.hexdigest()


def test_episodes_are_the_same_in_every_process_and_version() -> None:
    program = "from test_env import trajectory_hash; print(trajectory_hash())"
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parent,
        env=os.environ | {"PYTHONHASHSEED": "123"},
    )
    assert done.stdout.strip() == trajectory_hash() == HASH


@pytest.mark.parametrize("budget", ["battery", "max_steps"])
def test_budgets_that_arrays_have_no_room_for_are_refused(budget: str) -> None:
    for made in (make, partial(make_vec, 2, "NextStep")):
        with pytest.raises(ValueError, match=f"{budget} is {2**31}; it must be at most"):
            made(**{budget: 2**31})
        made(**{budget: 2**31 - 1}).close()


def test_a_layout_of_none_is_the_one_that_the_environment_has() -> None:
    env = make(layout=ROOM, randomize=False)
    env.reset(options={"layout": None})
    assert env.unwrapped.warehouse.layout == ROOM


def test_environments_do_not_share_a_motion_that_both_were_given() -> None:
    motion = GridMotion()
    one, other = (plain(backend=motion) for _ in range(2))
    at = one.reset(seed=1)[0]["robot_pos"]
    other.reset(seed=2)
    assert one.step(WAIT)[0]["robot_pos"].tolist() == at.tolist()


@pytest.mark.parametrize("radius", [np.int8(6), np.uint8(8)])
def test_a_small_integer_of_numpy_makes_no_other_space(radius: np.integer) -> None:
    for made in (make, partial(make_vec, 2, "NextStep")):
        with closing(made(view_radius=radius)) as env:
            assert env.observation_space.contains(env.reset(seed=0)[0])


def test_a_window_that_no_space_should_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="view_radius is 501; it must be at most 500"):
        make(view_radius=501)


def test_masks_are_of_an_episode() -> None:
    for env in (plain(), make_vec(2, "NextStep")):
        with pytest.raises(ResetNeeded):
            env.action_masks()


def test_a_closed_environment_says_that_it_is_closed() -> None:
    env = plain()
    env.reset(seed=0)
    env.close()
    with pytest.raises(ResetNeeded, match="the environment has been closed"):
        env.step(WAIT)
