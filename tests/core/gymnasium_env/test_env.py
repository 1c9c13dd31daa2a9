"""``Warehouse-v0`` with the checkers and wrappers of Gymnasium.

Every warning is an error here (``pyproject.toml``), including the warnings of the checkers. The
tests run with all versions of Gymnasium from 1.0 on, and skip features that 1.0 lacks.
"""

import copy
import pickle
from typing import Any, ClassVar
from unittest.mock import Mock

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import (
    FlattenObservation,
    RecordEpisodeStatistics,
    TimeAwareObservation,
    TimeLimit,
)
from helpers.gymnasium_envs import CORRIDOR, ROOM, make, plain, same, walk

from warehouse_core import Layout, LayoutError, WarehouseEnv, random_layout
from warehouse_core.errors import NoDisplayError
from warehouse_core.gymnasium_env import ID, WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env import env as gymnasium_env_module
from warehouse_core.gymnasium_env.spaces import FORMS, RENDER_FPS
from warehouse_core.gymnasium_env.vector import WarehouseVectorEnv
from warehouse_core.motion.grid import GridMotion
from warehouse_core.render.observation_image import ObservationImage
from warehouse_core.task.encoding import encode, vector

NORTH, EAST, SOUTH, WEST, WAIT, PICK, DROP = range(7)

over_forms = pytest.mark.parametrize("form", FORMS)


@pytest.mark.parametrize(
    ("backend", "form", "render_mode"),
    [("grid", "dict", None), ("grid", "vector", "ansi"), ("physics", "image", "rgb_array")],
)
def test_the_checker_of_gymnasium_passes_without_a_display(
    backend: str, form: str, render_mode: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    env = plain(backend=backend, observation=form, render_mode=render_mode)
    check_env(env)
    env.close()


@pytest.mark.parametrize(
    ("platform", "name", "modes"),
    [
        ("linux", "DISPLAY", ["human", "rgb_array", "ansi"]),
        ("linux", "WAYLAND_DISPLAY", ["human", "rgb_array", "ansi"]),
        ("linux", "NO_DISPLAY", ["rgb_array", "ansi"]),
        ("darwin", "NO_DISPLAY", ["human", "rgb_array", "ansi"]),
    ],
)
def test_a_window_is_a_mode_where_there_may_be_a_display(
    platform: str, name: str, modes: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for each in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(each, raising=False)
    monkeypatch.setenv(name, ":1")
    monkeypatch.setattr("sys.platform", platform)
    assert plain().metadata["render_modes"] == modes
    assert WarehouseGymnasiumEnv.metadata["render_modes"] == ["human", "rgb_array", "ansi"]


@over_forms
def test_observations_equal_those_of_the_chapters_environment(form: str) -> None:
    env = plain(layout=ROOM, observation=form, max_steps=12)
    image = ObservationImage(4, 5, battery=200, max_steps=12)
    of = {"dict": lambda arrays: arrays, "vector": vector, "image": image.paint}[form]
    for seed in range(5):
        found, _ = env.reset(seed=seed)
        start = env.warehouse.state.robot_pos
        twin = WarehouseEnv(env.warehouse.layout, start, max_steps=12)
        assert same(found, of(encode(twin.observe())))
        over = False
        while not over:
            action = (PICK, WEST, NORTH, DROP, EAST)[twin.state.steps % 5]
            found, *verdict, _ = env.step(action)
            expected, *other_verdict, _ = twin.step(action)
            assert same(found, of(encode(expected)))
            assert same(tuple(verdict), tuple(other_verdict))
            assert [type(value) for value in verdict] == [float, bool, bool]
            over = verdict[1] or verdict[2]


class SeedRecorder(GridMotion):
    """A grid that records the seeds of its resets."""

    seeds: ClassVar[list[int | None]] = []

    def reset(self, layout: Layout, cells: Any, seed: int | None) -> None:
        super().reset(layout, cells, seed)
        self.seeds.append(seed)


@pytest.mark.parametrize("randomize", [False, True], ids=["as given", "random"])
def test_the_seed_of_the_motion_follows_from_the_seed(randomize: bool) -> None:
    env = plain(backend=SeedRecorder, randomize=randomize)
    SeedRecorder.seeds.clear()
    for seed in (1, None, 1, None, 2):
        env.reset(seed=seed)
    first, second, *again, other = SeedRecorder.seeds
    assert again == [first, second]
    assert len({first, second, other}) == 3
    assert all(type(seed) is int for seed in (first, second, other))


def overwrite(data: Any) -> None:
    """Overwrite every array in a result of an environment."""
    if isinstance(data, np.ndarray):
        data[...] = 77
    elif isinstance(data, (dict, tuple)):
        for value in data.values() if isinstance(data, dict) else data:
            overwrite(value)


@over_forms
def test_changing_returned_values_changes_nothing_else(form: str) -> None:
    env, twin = (plain(layout=ROOM, observation=form) for _ in range(2))
    for seed in range(3):
        found, expected = env.reset(seed=seed), twin.reset(seed=seed)
        for action in (EAST, PICK, SOUTH, WEST, NORTH, EAST, EAST, WEST):
            assert same(found, expected)
            overwrite(found)
            overwrite(env.action_masks())
            found, expected = env.step(action), twin.step(action)


def test_a_step_after_the_end_raises_until_a_reset() -> None:
    env = plain(layout=ROOM, randomize=False)
    for name, arguments in (("step", [EAST]), ("action_masks", [])):
        with pytest.raises(ResetNeeded, match=rf"{name}\(\): there has been no reset\(\) yet"):
            getattr(env, name)(*arguments)
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
    env.close()
    with pytest.raises(ResetNeeded, match="the environment has been closed"):
        env.step(WAIT)


@pytest.mark.parametrize(
    ("action", "error", "message"),
    [
        (7, ValueError, r"action 7 is out of range; allowed: 0\.\.6"),
        (1.0, TypeError, r"action 1\.0 is float; allowed: an integer 0\.\.6"),
        ([1], TypeError, r"action \[1\]"),
    ],
    ids=repr,
)
def test_an_invalid_action_raises_and_changes_nothing(action, error, message) -> None:
    env = plain()
    env.reset(seed=0)
    before = pickle.dumps(env)
    with pytest.raises(error, match=message):
        env.step(action)
    assert pickle.dumps(env) == before


def test_options_apply_to_one_episode() -> None:
    other = Layout(["#####", "#...#", "#DP.#", "#####"])
    env = plain(layout=ROOM, start_pos=(2, 3), randomize=False)
    default, _ = env.reset()
    assert default["robot_pos"].tolist() == [2, 3]
    found, _ = env.reset(options={"start_pos": [1, 2]})
    assert found["robot_pos"].tolist() == [1, 2]
    found, info = env.reset(options={"layout": other.rows})
    assert found["pickup_pos"].tolist() == [2, 2]
    assert info["action_mask"].tolist() == [1, 0, 0, 1, 1, 0, 0]
    random = [env.reset(options={"randomize": True})[0] for _ in range(9)]
    assert len({tuple(each["robot_pos"]) for each in random}) > 2
    assert same(env.reset()[0], default)
    for options in ({}, {"layout": None}):
        assert same(env.reset(options=options)[0], default)
    env = plain(layout=ROOM)
    found, _ = env.reset(seed=1, options={"randomize": False})
    assert found["pickup_pos"].tolist() == [1, 1]
    found, _ = env.reset(seed=1, options={"randomize": "start"})
    assert found["pickup_pos"].tolist() == [1, 1]
    found, _ = env.reset(seed=1, options={"start_pos": (2, 2)})
    assert found["robot_pos"].tolist() == [2, 2]
    assert same(found["pickup_pos"], env.reset(seed=1)[0]["pickup_pos"])


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        (["layout"], TypeError, r"options is \['layout'\]; it must be a dict"),
        ({"randomize": "no"}, ValueError, "randomize is 'no'; allowed: False, True, 'stations', '"),
        ({"sed": 1, "a": 2}, ValueError, "unknown options: 'a', 'sed'; allowed: layout, ra"),
        ({"layout": CORRIDOR}, LayoutError, "has 1 x 6 cells; this environment was made for 4 x 5"),
        ({"layout": ["##", "#"]}, LayoutError, "row 1 has 1 columns"),
        ({"layout": ["#####"] * 3 + ["###.#"]}, LayoutError, "two open cells"),
        ({"start_pos": (0, 0)}, LayoutError, "start_pos row 0, column 0 is wall"),
        ({"start_pos": 3}, TypeError, "start_pos is 3; it must be two integers"),
        ({"start_pos": (1, 1), "layout": ["###.#"] * 4}, LayoutError, "row 1, column 1 is wall"),
    ],
    ids=repr,
)
def test_invalid_options_raise_and_change_nothing(options, error, message) -> None:
    env = plain(layout=ROOM)
    env.reset(seed=4)
    env.step(EAST)
    before = pickle.dumps(env)
    with pytest.raises(error, match=message):
        env.reset(seed=5, options=options)
    assert pickle.dumps(env) == before


def test_rendering_without_a_mode_warns() -> None:
    env = plain()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="needs a render_mode, given to gymnasium.make"):
        assert env.render() is None
    batch = WarehouseVectorEnv(2)
    batch.reset(seed=0)
    with pytest.warns(UserWarning, match="given to gymnasium.make_vec"):
        assert batch.render() is None


def test_the_window_shows_every_reset_and_step(monkeypatch: pytest.MonkeyPatch) -> None:
    window, opened = Mock(), Mock()
    opened.return_value = window
    monkeypatch.setattr(gymnasium_env_module, "PictureWindow", opened)
    env, still = (plain(render_mode=mode) for mode in ("human", "rgb_array"))
    opened.assert_not_called()
    for each in (env, still):
        each.reset(seed=0)
    expected = [still.render()]
    for action in (EAST, SOUTH, WEST):
        env.step(action), still.step(action)
        expected.append(still.render())
    assert env.render() is None
    opened.assert_called_once_with("Warehouse")
    pictures, rates = zip(*(call.args for call in window.show.call_args_list), strict=True)
    assert rates == (RENDER_FPS,) * 4
    assert same(pictures, tuple(expected))
    env.close()
    env.close()
    window.close.assert_called_once()


def test_a_window_without_a_display_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_core.render.window.has_display", lambda: False)
    env = plain(render_mode="human")
    with pytest.raises(NoDisplayError, match='render_mode="human" needs a window'):
        env.reset()
    env.close()


@over_forms
def test_a_copy_and_a_pickle_continue_like_the_original(form: str) -> None:
    env = plain(layout=ROOM, observation=form, render_mode="rgb_array", max_steps=6)
    walk(env, seed=3, steps=16)
    copies = [env, copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    found = []
    for each in copies:
        found.append([each.step(EAST), each.render(), each.reset(), each.step(EAST)])
    assert all(same(tuple(found[0]), tuple(other)) for other in found[1:])


def test_wrappers_of_gymnasium_work() -> None:
    flat = FlattenObservation(make(view_radius=1))
    # 9 codes, which are not made one-hot, + 2 + one-hot 2 + 1 + 1 + 2 + 2.
    assert flat.observation_space.shape == (19,)
    for observation, *_ in walk(flat, seed=0):
        assert observation in flat.observation_space
    counted = RecordEpisodeStatistics(make(max_steps=4))
    ends = [found[-1]["episode"] for found in walk(counted, seed=0) if "episode" in found[-1]]
    assert ends
    assert {int(end["l"]) for end in ends} == {4}
    for short in (TimeLimit(make(), max_episode_steps=3), make(max_episode_steps=3)):
        short.reset(seed=0)
        assert [short.step(WAIT)[3] for _ in range(3)] == [False, False, True]


def test_the_spec_has_the_limit_of_steps() -> None:
    env = make(observation="vector", max_steps=7)
    assert env.spec.max_episode_steps == env.unwrapped.spec.max_episode_steps == 7
    assert make(max_steps=7, max_episode_steps=3).spec.max_episode_steps == 3
    assert gymnasium.spec(ID).max_episode_steps is None
    bare = plain()
    bare.spec = None
    assert bare.spec is None
    timed = TimeAwareObservation(env, normalize_time=True)
    timed.reset(seed=0)
    assert [float(timed.step(WAIT)[0][-1]) for _ in range(7)] == pytest.approx(
        [step / 7 for step in range(1, 8)]
    )


def test_the_same_seed_gives_the_same_episodes_after_any_others() -> None:
    env = plain(layout=random_layout(9, 9, 0.2, seed=0))
    first, starts = walk(env, seed=6), [env.reset()[0] for _ in range(4)]
    assert same(tuple(walk(env, seed=6)), tuple(first))
    assert len({str(start) for start in starts}) > 1
    assert not same(tuple(walk(env, seed=7)), tuple(first))
