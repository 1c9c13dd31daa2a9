import copy
import dataclasses
import math
import re
import tempfile
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import (
    Episode,
    EpisodeRecorder,
    Layout,
    RecordError,
    Settings,
    WarehouseEnv,
    record_episode,
    replay_episode,
)
from warehouse_core.files import npz as safe_npz_module
from warehouse_core.motion.base import Outcome
from warehouse_core.motion.grid import GridMotion
from warehouse_core.world.actions import ACTIONS

LINE = Layout(["P..D"])


class Script:
    """Carries out a list of actions."""

    def __init__(self, *actions: Any) -> None:
        self.actions = actions

    def reset(self) -> None:
        self.left = list(self.actions)

    def act(self, observation: object) -> Any:
        return self.left.pop(0)


def on_line(*actions: Any, **limits: int) -> Episode:
    env = WarehouseEnv(LINE, start_pos=(0, 0), **limits)
    return record_episode(env, Script(*actions), seed=5, randomize=False)


ABSURD = (
    10**5000, 2**63, -(2**31) - 1, 2**53 + 1, 1.5, 1e300, math.nan, math.inf, True, None, "",
    "\udcff", "x" * 10_000, b"N", [], [1], {}, (), (0, 0), (0.5, 0), (0, 0, 0), object(),
    np.int64(1), np.float32(0.1), np.bool_(True), np.zeros((2, 4)), np.longdouble("0.1"),
)  # fmt: skip


def with_absurd(name: str, value: Any) -> Iterator[Episode]:
    """Yield a record with a field replaced, or its first entry or a part of that, if it has any."""
    original = on_line("PICK", "E", "W", "W", max_steps=4)
    first = getattr(original, name)
    if isinstance(first, list) and first:
        yield dataclasses.replace(original, **{name: [value, *first[1:]]})
        first = first[0]
    for part in getattr(first, "_fields", getattr(first, "__slots__", ())):
        change = dataclasses.replace if dataclasses.is_dataclass(first) else Outcome._replace
        changed = change(first, **{part: value})
        whole = [changed, *original.motions[1:]] if name == "motions" else changed
        yield dataclasses.replace(original, **{name: whole})
    yield dataclasses.replace(original, **{name: value})


DELIVERY = ("PICK", "E", "e", 1, np.int64(1), "DROP")


# Recording.


def test_a_record_holds_every_frame_and_every_step() -> None:
    episode = on_line(*DELIVERY)
    assert (episode.layout, episode.seed, episode.agent) == (LINE, 5, "Script")
    assert episode.settings == Settings("grid", 1.0, (0, 0), 200, 200, 2)
    assert episode.cells == [(0, 0), (0, 0), (0, 1), (0, 2), (0, 3), (0, 3), (0, 3)]
    assert episode.loaded == [False, True, True, True, True, True, False]
    assert episode.battery == [200, 199, 198, 197, 196, 195, 194]
    assert episode.rewards == pytest.approx([0, 4.9, -0.1, -0.1, -0.1, -1.1, 9.9])
    assert episode.actions == ["PICK", "E", "e", 1, 1, "DROP"]
    assert [type(action) for action in episode.actions] == [str, str, str, int, int, str]
    assert episode.reasons == [""] * 6
    assert [motion.cell for motion in episode.motions] == episode.cells[1:]
    assert [motion.blocked for motion in episode.motions] == [False] * 4 + [True, False]
    assert (episode.terminated, episode.truncated, episode.steps) == (True, False, 6)
    assert episode.total_reward == pytest.approx(13.4)


def test_a_record_starts_where_the_reset_left_the_robot(episode: Episode) -> None:
    env = WarehouseEnv(max_steps=60)
    first = env.reset(randomize=True, seed=3)
    assert episode.layout == env.layout
    assert episode.cells[0] == first["robot_pos"]
    assert episode.steps == 60


def test_an_agents_reason_is_kept_with_its_action(episode: Episode) -> None:
    assert len(episode.reasons) == episode.steps
    assert set(episode.reasons) == {"", "because", "müde"}


def test_the_agent_is_reset_before_each_episode() -> None:
    script, env = Script(*DELIVERY), WarehouseEnv(LINE, start_pos=(0, 0))
    first, second = (record_episode(env, script, randomize=False) for _ in range(2))
    assert first == second


def test_a_record_is_not_changed_by_what_the_environment_does_next() -> None:
    env = WarehouseEnv(LINE, start_pos=(0, 0))
    episode = record_episode(env, Script(*DELIVERY), randomize=False)
    before = copy.deepcopy(episode)
    record_episode(env, Script(*["WAIT"] * 200), randomize=True, seed=1)
    assert episode == before


def test_a_recorder_is_driven_by_hand() -> None:
    env = WarehouseEnv(LINE, start_pos=(0, 0))
    recorder = EpisodeRecorder(env, agent="me")
    assert recorder.step("PICK", reason="here it is")["has_item"]
    assert not recorder.ended
    assert recorder.episode.outcome == "unfinished"
    for action in ("E", "E", "E", "DROP"):
        recorder.step(action)
    assert recorder.ended
    assert (recorder.episode.agent, recorder.episode.seed) == ("me", None)
    assert recorder.episode.reasons == ["here it is", "", "", "", ""]


def test_a_step_that_raises_is_not_recorded() -> None:
    recorder = EpisodeRecorder(WarehouseEnv(), agent="me")
    with pytest.raises(TypeError):
        recorder.step(1.5)
    assert recorder.episode.steps == 0
    assert len(recorder.episode.cells) == 1


@pytest.mark.parametrize(
    ("actions", "limits", "outcome"),
    [
        (DELIVERY, {}, "delivered"),
        (DELIVERY, {"battery": 6}, "delivered"),
        (DELIVERY, {"max_steps": 6}, "delivered"),
        (DELIVERY, {"battery": 5}, "battery depleted"),
        (DELIVERY, {"battery": 5, "max_steps": 5}, "battery depleted"),
        (DELIVERY, {"max_steps": 5}, "out of time"),
    ],
)
def test_the_outcome_of_an_episode(
    actions: tuple[Any], limits: dict[str, int], outcome: str
) -> None:
    assert on_line(*actions, **limits).outcome == outcome


# Frames and measures.


def test_the_repr_is_one_line() -> None:
    delivered = "<Episode delivered, 6 steps, reward 13.40, seed 5, agent 'Script'>"
    assert repr(on_line(*DELIVERY)) == delivered
    assert repr(on_line("E", max_steps=1)).startswith("<Episode out of time, 1 step, reward -0.10,")
    empty = Episode(LINE, WarehouseEnv(LINE, None).settings, None, "")
    assert repr(empty) == "<Episode unfinished, 0 steps, reward 0.00, seed None, agent ''>"


def test_frames_equal_render_grid() -> None:
    env = WarehouseEnv()
    env.reset(randomize=True, seed=2)
    recorder, frames = EpisodeRecorder(env), [env.render_grid()]
    for action in ("E", "E", "S", "PICK", "fly"):
        recorder.step(action)
        frames.append(env.render_grid())
    assert recorder.episode.frames == frames


def test_frames_show_a_loaded_robot() -> None:
    assert [frame[0] for frame in on_line(*DELIVERY).frames[:3]] == [
        ["R", ".", ".", "D"],
        ["r", ".", ".", "D"],
        ["P", "r", ".", "D"],
    ]


def test_frames_are_new_lists() -> None:
    episode = on_line(*DELIVERY)
    episode.frames[0][0][0] = "?"
    assert episode.frames[0][0][0] == "R"


def test_metrics_are_the_four_lists_of_the_chapter() -> None:
    metrics = on_line(*DELIVERY).metrics
    assert metrics.keys() == {"rewards", "battery", "dist_pickup", "dist_dropoff"}
    assert metrics["rewards"] == pytest.approx([0, 4.9, -0.1, -0.1, -0.1, -1.1, 9.9])
    assert metrics["battery"] == [200, 199, 198, 197, 196, 195, 194]
    assert metrics["dist_pickup"] == [0, 0, 1, 2, 3, 3, 3]
    assert metrics["dist_dropoff"] == [3, 3, 2, 1, 0, 0, 0]


def test_a_distance_to_no_station_is_nan() -> None:
    env = WarehouseEnv(["..D"], start_pos=(0, 0), max_steps=1)
    metrics = record_episode(env, Script("E"), randomize=False).metrics
    assert all(math.isnan(distance) for distance in metrics["dist_pickup"])
    assert metrics["dist_dropoff"] == [2, 1]


# Files.


def test_a_record_loads_as_it_was_saved(episode: Episode, saved: Path) -> None:
    loaded = Episode.load(saved)
    assert loaded == episode
    assert loaded.motions == episode.motions
    assert loaded.total_reward == episode.total_reward
    kinds = {type(value) for cell in loaded.cells for value in cell}
    kinds |= {type(value) for value in loaded.battery}
    assert kinds == {int}
    assert {type(value) for value in loaded.rewards} == {float}
    assert {type(value) for value in loaded.loaded} == {bool}
    assert [type(a) for a in loaded.actions] == [type(a) for a in episode.actions]
    assert any(motion.contacts for motion in loaded.motions)
    assert not any(motion.path.flags.writeable for motion in loaded.motions)


def test_records_that_differ_in_one_value_are_not_equal(episode: Episode) -> None:
    twin = copy.deepcopy(episode)
    assert twin == episode
    twin.motions[3] = twin.motions[3]._replace(path=twin.motions[3].path + 1e-12)
    assert twin != episode


@settings(max_examples=15)
@given(
    st.lists(st.sampled_from(ACTIONS) | st.integers() | st.text(max_size=3), max_size=12),
    st.none() | st.integers(),
)
def test_any_actions_load_as_they_were_saved(actions: list[str | int], seed: int | None) -> None:
    env = WarehouseEnv()
    env.reset(seed=seed)
    recorder = EpisodeRecorder(env, seed=seed, agent="any")
    for action in actions:
        recorder.step(action, reason=str(action))
    with tempfile.TemporaryDirectory() as folder:
        recorder.episode.save(Path(folder) / "any.npz")
        assert Episode.load(Path(folder) / "any.npz") == recorder.episode


FROM_SETTINGS = {"layout", "backend", "cell_size", "slippery", "motor_strength"}


@pytest.mark.parametrize("name", sorted(set(Episode.__slots__) - FROM_SETTINGS))
def test_a_record_of_any_values_loads_as_it_was_saved_or_raises(tmp_path: Path, name: str) -> None:
    path = tmp_path / "any.npz"
    refused = 0
    for episode in chain.from_iterable(with_absurd(name, value) for value in ABSURD):
        try:
            episode.save(path)
        except RecordError:
            assert list(tmp_path.iterdir()) == []
            refused += 1
        else:
            assert Episode.load(path) == episode
            path.unlink()
    assert refused


def test_an_action_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=r"any\.npz: actions cannot be written as JSON: Exceeds"):
        next(with_absurd("actions", 10**5000)).save(tmp_path / "any.npz")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("cells", (2**31, 0), "cells cannot be stored as int32 with 2 dimensions"),
        ("loaded", 2, "loaded cannot be stored as bool with 1 dimensions"),
        ("battery", 2**63, "battery cannot be stored as int64"),
        ("rewards", 10**400, "rewards cannot be stored as float64"),
        ("rewards", "1", "rewards cannot be stored as float64"),
        ("rewards", math.nan, "rewards has a number outside -1e+12..1e+12"),
        ("seed", 1.5, "seed is 1.5; it must be int"),
        ("seed", object(), "seed cannot be written as JSON"),
        ("reasons", 5, "reasons must be a list of words"),
    ],
)
def test_a_value_that_would_change_is_named(
    tmp_path: Path, name: str, value: Any, message: str
) -> None:
    with pytest.raises(RecordError, match=re.escape(message)):
        next(with_absurd(name, value)).save(tmp_path / "any.npz")


def test_a_seed_of_numpy_is_saved(tmp_path: Path) -> None:
    record_episode(WarehouseEnv(), GreedyAgent(0), seed=np.int64(3)).save(tmp_path / "any.npz")
    assert Episode.load(tmp_path / "any.npz").seed == 3


def test_a_record_without_a_step_loads_as_it_was_saved(tmp_path: Path) -> None:
    episode = EpisodeRecorder(WarehouseEnv()).episode
    episode.save(tmp_path / "empty.npz")
    assert Episode.load(tmp_path / "empty.npz") == episode


def test_saving_twice_gives_the_same_arrays(episode: Episode, tmp_path: Path) -> None:
    for name in ("one.npz", "two.npz"):
        episode.save(tmp_path / name)
    with np.load(tmp_path / "one.npz") as one, np.load(tmp_path / "two.npz") as two:
        assert one.files == two.files
        assert all(np.array_equal(one[name], two[name]) for name in one.files)


def test_a_record_that_is_too_large_raises_before_a_file_is_created(
    episode: Episode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(safe_npz_module, "MAX_BYTES", 1000)
    with pytest.raises(RecordError, match=r"large\.npz: .* are more than MAX_BYTES = 1000"):
        episode.save(tmp_path / "large.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_save_that_fails_does_not_change_the_existing_file(
    episode: Episode, saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = saved.read_bytes()

    def half(file: Any, **arrays: Any) -> None:
        file.write(b"half of a record")
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez_compressed", half)
    with pytest.raises(OSError, match="no space left"):
        episode.save(saved)
    assert saved.read_bytes() == before
    assert list(saved.parent.iterdir()) == [saved]


# Replays.


def test_a_replay_is_equal_bit_for_bit(episode: Episode) -> None:
    assert replay_episode(episode) == episode


def test_a_loaded_record_replays_equally(episode: Episode, saved: Path) -> None:
    assert replay_episode(Episode.load(saved)) == episode


@pytest.mark.parametrize("seed", range(5))
def test_episodes_replay_from_a_random_start(seed: int) -> None:
    env = WarehouseEnv(battery=60, view_radius=1)
    episode = record_episode(env, GreedyAgent(seed=seed), seed=seed)
    assert replay_episode(episode) == episode


@pytest.mark.parametrize("backend", ["grid", "physics"])
def test_a_record_with_charging_is_saved_and_replayed(tmp_path: Path, backend: str) -> None:
    env = WarehouseEnv(["PCD"], (0, 0), battery=14, backend=backend)
    script = ("PICK", "E", "E", "W", "WAIT", "WAIT", "WAIT", "E", "DROP")
    episode = record_episode(env, Script(*script), randomize=False)
    assert episode.battery == [14, 13, 12, 11, 10, 14, 14, 14, 13, 12]
    assert episode.outcome == "delivered"
    episode.save(tmp_path / "charged.npz")
    loaded = Episode.load(tmp_path / "charged.npz")
    assert loaded == episode == replay_episode(loaded)
    assert loaded.layout.chargers == ((0, 1),)


def test_a_replay_uses_the_radius_and_budgets_of_the_record() -> None:
    env = WarehouseEnv(LINE, (0, 1), 7, 3, 1)
    episode = record_episode(env, Script("E", "E", "E"), randomize=False)
    assert replay_episode(episode).settings == episode.settings
    assert replay_episode(episode) == episode


def test_a_replay_on_another_backend_keeps_the_rules_and_names_the_backend(
    episode: Episode,
) -> None:
    replayed = replay_episode(episode, backend=GridMotion(cell_size=0.5))
    assert replayed.rewards == episode.rewards
    assert replayed.cells == episode.cells
    assert replayed.settings.backend == "GridMotion"
    assert replayed.settings.cell_size == 0.5
    assert replayed.motions != episode.motions


def test_a_replay_does_not_change_the_record(episode: Episode) -> None:
    before = copy.deepcopy(episode)
    replay_episode(episode)
    assert episode == before


def test_a_replay_resets_the_motion_to_the_start_and_seed_of_the_record(episode: Episode) -> None:
    resets = []

    class Recording(GridMotion):
        def reset(self, layout: Layout, cells: Any, seed: int | None) -> None:
            resets.append((layout, list(cells), seed))
            super().reset(layout, cells, seed)

    replay_episode(episode, backend=Recording())
    assert resets[-1] == (episode.layout, [episode.cells[0]], 3)
