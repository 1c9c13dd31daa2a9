"""Several tracks in one picture."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import pytest

from agents.run_episode import run_episode
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Episode, Layout, WarehouseEnv, record_episode
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.grid_track import track_of_frames
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

MAX_PIXELS = 1366


@pytest.fixture(scope="module")
def episodes() -> tuple[Episode, Episode]:
    return run_episode(seed=12), run_episode(backend="physics", seed=12)


@pytest.fixture
def grid(episodes: tuple[Episode, Episode]) -> Track:
    return track_of_record(episodes[0])


@pytest.fixture
def physics(episodes: tuple[Episode, Episode]) -> Track:
    return track_of_record(episodes[1])


def boxes(scene: Scene) -> Iterator[Any]:
    """Yield the boxes of everything that must not overlap."""
    scene.root.canvas.draw()
    words = [text for text in scene.root.texts if text.get_text() and text.get_visible()]
    bounds: dict[Any, Any] = {axes.bbox.bounds: axes for axes in scene.root.axes}
    for artist in (*words, *scene.root.legends, *bounds.values()):
        yield artist.get_window_extent()


def check_boxes(scene: Scene) -> None:
    """Raise if something overlaps or leaves the picture."""
    found = list(boxes(scene))
    for number, box in enumerate(found):
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= scene.root.bbox.x1 + 1e-6
        assert box.y1 <= scene.root.bbox.y1
        assert not any(box.overlaps(each) for each in found[number + 1 :])


LONG = "goes round a wall that it has met before, because every other way is longer still " * 3


def corridor() -> Track:
    env = WarehouseEnv(Layout(["P" + "." * 60 + "D"]), (0, 5), max_steps=3)
    return track_of_record(record_episode(env, GreedyAgent(seed=0), randomize=False))


def test_nothing_overlaps_nor_leaves_a_picture_of_1366_pixels(grid: Track, physics: Track) -> None:
    plain, wide = track_of_frames([["R."], [".R"]]), corridor()
    for track in (grid, physics, plain, wide):
        for frame in track.frames:
            frame.caption = LONG
    for tracks in ((grid, plain), (grid, wide, physics)):
        scene = Scene(tracks, make_figure)
        assert scene.root.bbox.width <= MAX_PIXELS
        assert scene.root.bbox.height <= 800
        scene.show(len(scene) - 1)
        check_boxes(scene)


def test_more_than_four_tracks_are_in_rows_of_three_and_have_no_charts(grid, physics) -> None:
    tracks = [grid, physics, grid, dataclasses.replace(physics, ending="battery depleted"), grid]
    scene = Scene(tracks, make_figure)
    scene.show(len(scene) - 1)
    assert scene.root.bbox.width <= MAX_PIXELS
    maps = [axes.get_position() for axes in scene.root.axes if axes.get_aspect() == 1]
    rows = maps[:3], maps[3:]
    assert [place.x0 for place in rows[0][:2]] == [place.x0 for place in rows[1]]
    assert [len({round(place.y1, 6) for place in row}) for row in rows] == [1, 1]
    assert len(scene.root.axes) == 2 * len(tracks), "maps and batteries"
    check_boxes(scene)
