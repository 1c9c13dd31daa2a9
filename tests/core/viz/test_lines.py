"""Rays of range scans, and outlines of crates and other bodies, in records and all pictures."""

from pathlib import Path

import numpy as np
import pytest
from helpers.pictures import pixels, press
from helpers.player import said_by

from agents.run_episode import run_episode
from warehouse_core import Episode, replay_animation
from warehouse_core.viz.replay import Replay

RAY, OUTLINE = (1.0, 1.5, 1.5, 9.5, 1.5), (0.0, 4.2, 3.2, 4.8, 3.8)


def seen(*lines: tuple[float, ...]) -> Episode:
    """Return an episode whose first motion has a ray, and whose second has ``lines``."""
    episode = run_episode(seed=12, max_steps=2)
    for number, rows in enumerate(([RAY], lines)):
        array = np.array(rows, float).reshape(-1, 5)
        episode.motions[number] = episode.motions[number]._replace(lines=array)
    return episode


def replay_of(*lines: tuple[float, ...]) -> Replay:
    replay = replay_animation(seen(*lines), window=False)
    assert replay is not None
    replay.go_to(2)
    return replay


def test_a_record_keeps_its_lines(tmp_path: Path) -> None:
    episode = seen(RAY, OUTLINE)
    episode.save(tmp_path / "record.npz")
    loaded = Episode.load(tmp_path / "record.npz")
    assert loaded == episode
    assert loaded != seen(OUTLINE, RAY)
    assert [len(motion.lines) for motion in loaded.motions] == [1, 2]
    copy = loaded.motions[0].copy()
    copy.lines[0, 1] = 7.0
    assert loaded.motions[0].lines[0, 1] == 1.5


def test_a_page_has_the_lines_of_each_frame(tmp_path: Path) -> None:
    replay_of(RAY, OUTLINE).save(tmp_path / "page.html")
    data = said_by((tmp_path / "page.html").read_text(encoding="utf-8"))["tracks"][0]["lines"]
    assert data["isRay"] == [True, False]
    assert data["toX"] == pytest.approx([0, 9.5, 9.5, 0, 0, 4.8], abs=1e-3)
    assert data["y"] == pytest.approx([0, 1.5, 1.5, 0, 0, 3.2], abs=1e-3)


def test_v_hides_rays_but_not_outlines() -> None:
    bare, replay, only_outline = replay_of(), replay_of(RAY, OUTLINE), replay_of(OUTLINE)
    both, outline = pixels(replay), pixels(only_outline)
    press(replay, "v")
    one_ray, none = pixels(replay), pixels(bare)
    width = one_ray.shape[1] // 2  # the legends to the right differ
    assert (both[:, :width] != one_ray[:, :width]).any()
    assert (one_ray[:, :width] == outline[:, :width]).all()
    assert (one_ray[:, :width] != none[:, :width]).any()


def test_a_drawing_shows_outlines(tmp_path: Path) -> None:
    replay_of(RAY, OUTLINE).save(tmp_path / "drawing.svg")
    assert "M420,320L480,380" in (tmp_path / "drawing.svg").read_text(encoding="utf-8")
