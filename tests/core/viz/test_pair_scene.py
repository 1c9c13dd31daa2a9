"""Two tracks in one picture."""

import dataclasses

import pytest

from agents.run_episode import run_episode
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.pair_scene import PairScene
from warehouse_core.viz.replay import replay_of_track
from warehouse_core.viz.tracks.episode_track import track_of_episode
from warehouse_core.viz.tracks.grid_track import track_of_frames


def texts(scene: PairScene) -> list[str]:
    """Return all texts in the figure and its parts."""
    from matplotlib.text import Text

    return [text.get_text() for text in scene.root.findobj(Text)]


@pytest.fixture(scope="module")
def episodes():
    return run_episode(seed=12), run_episode(backend="physics", seed=12)


def test_a_grid_and_a_continuous_track_advance_by_steps(episodes):
    grid, physics = map(track_of_episode, episodes)
    scene = PairScene(grid, physics, make_figure)
    assert len(scene) == len(physics)
    frame = [each.progress for each in physics.frames].index(5.0)
    scene.show(frame)
    assert [text for text in texts(scene) if text.startswith("step 5 of 23")] == [
        "step 5 of 23",
        f"step 5 of 23   {physics.frames[frame].clock:.1f} s",
    ]


def test_the_shorter_one_waits_at_its_end(episodes):
    long, short = track_of_episode(episodes[0]), track_of_episode(run_episode(seed=12, max_steps=4))
    scene = PairScene(long, short, make_figure)
    assert len(scene) == len(long)
    scene.show(len(scene) - 1)
    assert {"DELIVERED", "OUT OF TIME"} <= set(texts(scene))


def test_two_continuous_tracks_advance_by_time(episodes):
    track = track_of_episode(episodes[1])
    frames = [dataclasses.replace(frame, clock=2 * frame.clock) for frame in track.frames]
    slower = dataclasses.replace(track, frames=frames)
    scene = PairScene(track, slower, make_figure)
    scene.show(scene._moments.index(track.frames[-1].clock))
    shown = [text for text in texts(scene) if text.startswith("step ")]
    assert shown[0].startswith("step 23 of 23")
    assert not shown[1].startswith("step 23 of 23")


def test_there_is_one_legend_for_both(episodes):
    grid, physics = map(track_of_episode, episodes)
    assert texts(PairScene(grid, physics, make_figure)).count("#  wall") == 1


def test_the_legend_explains_chargers_of_either():
    tracks = [track_of_frames([[row]]) for row in ("R.", "RC")]
    for left, right in (tracks, tracks[::-1]):
        assert "C  charger" in texts(PairScene(left, right, make_figure))
    assert "C  charger" not in texts(PairScene(*tracks[:1] * 2, make_figure))


def test_a_replay_of_two_is_wider_than_high_and_as_fast_as_a_continuous_one(episodes):
    grid, physics = map(track_of_episode, episodes)
    replay = replay_of_track(grid, physics, window=False)
    width, height = replay.figure.get_size_inches()
    assert width > 2 * height
    assert replay.frame_ms == 50
