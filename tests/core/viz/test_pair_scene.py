"""Two tracks in one picture, and several robots in one track."""

import dataclasses

import numpy as np
import pytest

from agents.run_episode import run_episode
from warehouse_core.render.palette import COLORS
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import PairScene, Scene
from warehouse_core.viz.track import Pose, track_of_episode
from warehouse_core.warehouse_viz import replay_animation


def texts(scene: PairScene) -> list[str]:
    """Every text in the figure and its parts."""
    from matplotlib.text import Text

    return [text.get_text() for text in scene.root.findobj(Text)]


@pytest.fixture(scope="module")
def episodes():
    return run_episode(seed=12), run_episode(backend="physics", seed=12)


def test_a_grid_and_a_continuous_track_go_step_by_step(episodes):
    grid, physics = map(track_of_episode, episodes)
    scene = PairScene(grid, physics, make_figure)
    assert len(scene) == len(physics)
    frame = physics.progress.index(5.0)
    scene.show(frame)
    assert [text for text in texts(scene) if text.startswith("step 5 of 23")] == [
        "step 5 of 23",
        f"step 5 of 23   {physics.clock[frame]:.1f} s",
    ]


def test_the_shorter_one_waits_at_its_end(episodes):
    long, short = track_of_episode(episodes[0]), track_of_episode(run_episode(seed=12, max_steps=4))
    scene = PairScene(long, short, make_figure)
    assert len(scene) == len(long)
    scene.show(len(scene) - 1)
    assert {"DELIVERED", "OUT OF TIME"} <= set(texts(scene))


def test_two_continuous_tracks_go_by_the_clock(episodes):
    track = track_of_episode(episodes[1])
    slower = dataclasses.replace(track, clock=[2 * time for time in track.clock])
    scene = PairScene(track, slower, make_figure)
    scene.show(scene._moments.index(track.clock[-1]))
    shown = [text for text in texts(scene) if text.startswith("step ")]
    assert shown[0].startswith("step 23 of 23")
    assert not shown[1].startswith("step 23 of 23")


def test_there_is_one_legend_for_both(episodes):
    grid, physics = map(track_of_episode, episodes)
    assert texts(PairScene(grid, physics, make_figure)).count("hit") == 1


def test_a_replay_of_two_saves_both(episodes, tmp_path):
    replay = replay_animation(episodes[0], beside=episodes[1], window=False)
    target = tmp_path / "both.svg"
    replay.save(target)
    assert target.stat().st_size > 100_000
    width, height = replay.figure.get_size_inches()
    assert width > 2 * height


def test_further_robots_are_drawn_too(episodes):
    track = track_of_episode(episodes[0])
    track.others = [[Pose((1.5, 1.5), None, True)] * len(track)]
    alone = Scene(track_of_episode(episodes[0]), make_figure).root.pixels()
    crowd = Scene(track, make_figure).root.pixels()
    color = np.round(255 * np.array(COLORS["r"]))
    found = [np.all(np.asarray(image) == color, axis=-1).sum() for image in (alone, crowd)]
    assert found[1] > found[0] + 500
