"""The pixels and texts of a scene."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import (
    ROOM,
    count_color,
    is_color,
    patch,
    pixels,
    point_of,
    replay_of,
    short_episode,
    texts,
)

from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv
from warehouse_core.motion.base import Contact
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import (
    COLORS,
    ICE,
    ICE_WAVE,
    INK,
    ITEM,
    PAPER,
    SHADOW,
    blend,
)  # fmt: skip
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.legend import signs_of
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

BARE = ["#####", "#P.D#", "#..R#", "#####"]


def frames_at(*cells: tuple[int, int], robot: str = "R") -> list[list[list[str]]]:
    """Return frames of ``ROOM`` with the robot in these cells."""
    frames = []
    for row, column in cells:
        frame = [list(line) for line in ROOM.rows]
        frame[row][column] = robot
        frames.append(frame)
    return frames


# The grid.


def test_a_tile_has_its_colour_in_the_middle_and_at_the_edge_and_its_letter() -> None:
    replay = replay_of([[*BARE[:2], "#C.R#", "#####"]])
    image = pixels(replay)
    for tile, row, column in (("P", 1, 1), (".", 1, 2), ("C", 2, 1), ("D", 1, 3)):
        for right, down in ((0.45, 0.5), (0.9, 0.4), (0.4, 0.9), (0.1, 0.9)):
            pixel = image[point_of(replay, column + right, row + down)]
            assert is_color(pixel, COLORS[tile]), (tile, right, down)
        corner = patch(replay, image, column + 0.05, row + 0.05, column + 0.4, row + 0.4)
        assert (count_color(corner, INK) > 10) == (tile != "."), tile


@pytest.mark.parametrize(("robot", "ink"), [("R", PAPER), ("r", INK)])
def test_the_robot_is_a_disc_with_its_letter_and_its_item(
    robot: str, ink: tuple[float, float, float]
) -> None:
    replay = replay_of(frames_at((2, 2), robot=robot))
    image = pixels(replay)
    for right, down in ((0.25, 0.5), (0.75, 0.5), (0.5, 0.26), (0.5, 0.74)):
        assert is_color(image[point_of(replay, 2 + right, 2 + down)], COLORS[robot])
    assert count_color(patch(replay, image, 2.38, 2.36, 2.62, 2.64), ink) > 20
    items = count_color(patch(replay, image, 2.2, 2.2, 2.8, 2.8), ITEM)
    assert items > 100 if robot == "r" else items == 0


def test_everything_around_the_view_is_shaded() -> None:
    env = WarehouseEnv(["...........", "P.........D"], start_pos=(0, 5), view_radius=1)
    recorder = EpisodeRecorder(env)
    recorder.step("E")
    settings = dataclasses.replace(recorder.episode.settings, slippery=((0, 7),))
    episode = dataclasses.replace(recorder.episode, settings=settings)
    replay = replay_of(episode)
    for frame, seen in ((0, [4, 5, 6]), (1, [5, 6, 7])):
        replay.go_to(frame)
        image = pixels(replay)
        for x in range(11):
            tile = ICE if x == 7 else COLORS["P.D"[(x > 0) + (x == 10)]]
            y = 0.1 if x == 7 else 1.2
            color = tile if x in seen else blend(tile, INK, SHADOW)
            pixel = image[point_of(replay, x + 0.5, y)]
            np.testing.assert_allclose(pixel, 255 * np.array(color), atol=1.5, err_msg=str(x))
        waves = count_color(patch(replay, image, 7.1, 0.1, 7.9, 0.9), ICE_WAVE)
        assert (waves > 5) == (7 in seen)
    signs = signs_of(track_of_record(episode))
    assert {"slippery floor", "outside the robot's view"} <= {*signs}


def test_the_action_and_its_reason_are_the_largest_words() -> None:
    replay = replay_of(short_episode(reasons=["x " * 150, *["why"] * 5]))
    for frame in (1, 2):
        replay.go_to(frame)
        replay.figure.pixels()
        (said,) = [
            t for t in replay.figure.texts if t.get_text().startswith(("North: x", "West: why"))
        ]
        width = said.get_window_extent().x1
        assert width <= replay.figure.bbox.x1
    others = [text for axes in replay.figure.axes for text in axes.texts]
    sizes = [text.get_fontsize() for text in (*replay.figure.texts, *others) if text is not said]
    assert said.get_fontsize() > 1.3 * max(sizes)


def test_tiles_and_the_robot_may_come_and_go() -> None:
    replay = replay_of([["...", ".P."], ["R..", ".D."]])
    for frame, robot, tile in ((0, ".", "P"), (1, "R", "D"), (0, ".", "P")):
        replay.go_to(frame)
        image = pixels(replay)
        assert is_color(image[point_of(replay, 0.75, 0.5)], COLORS[robot])
        assert is_color(image[point_of(replay, 1.45, 1.5)], COLORS[tile])


@pytest.mark.parametrize(("height", "width"), [(1, 1), (1, 120), (120, 1), (60, 60)])
def test_a_layout_of_any_shape_fits_into_the_picture(height: int, width: int) -> None:
    rows = ["." * width] * height
    replay = replay_of([[["R", *rows[0][1:]], *rows[1:]]], {"battery": [1.0]})
    box = replay.figure.axes[0].get_window_extent()
    assert replay.figure.bbox.x0 <= box.x0 < box.x1 <= replay.figure.bbox.x1
    assert replay.figure.bbox.y0 <= box.y0 < box.y1 <= replay.figure.bbox.y1
    assert box.width / box.height == pytest.approx(width / height)
    # On cells this small the robot is larger than a cell, so that it can be seen.
    grid = patch(replay, pixels(replay), 0.0, 0.0, width - 0.01, height - 0.01)
    assert count_color(grid, COLORS["R"]) > 5


# Texts.


def test_the_words_of_each_frame_count_steps_and_say_what_was_done() -> None:
    replay = replay_of(short_episode())
    for frame, done in enumerate(
        ("", "North: why not", "West", "Pick up", "East", "East", "DELIVERED")
    ):
        replay.go_to(frame)
        assert {f"step {frame} of 6", done} - {""} <= {*texts(replay)}
        assert ("North: why not" in texts(replay)) == (frame == 1)
        assert ("DELIVERED" in texts(replay)) == (frame == 6)


def test_the_legend_has_what_is_in_the_picture_and_nothing_else() -> None:
    def legend_of(frames: Any) -> list[str]:
        (legend,) = replay_of(frames).figure.legends
        return [text.get_text() for text in legend.get_texts()]

    assert legend_of([BARE]) == ["R robot (empty)", "item", "P pickup", "D dropoff", "wall"]
    assert legend_of([["r.D"], [".rD"]]) == [
        "r robot (loaded)", "item", "trail, loaded", "D dropoff"
    ]  # fmt: skip
    bump = short_episode().motions[0]._replace(contacts=(Contact(0.1, 2.0, (2.5, 1.0), "wall"),))
    words = legend_of(short_episode(motions=[bump, *short_episode().motions[1:]]))
    assert {"hit", "outside the robot's view", "trail, empty", "R robot (empty)"} <= {*words}


# The charts.


# The battery.


# Tracks that grow.


def test_the_legend_explains_what_a_track_has_grown_by_and_no_more() -> None:
    env = WarehouseEnv(ROOM, (1, 2))
    recorder = EpisodeRecorder(env, seed=4)
    start = track_of_record(recorder.episode)
    scene = Scene([start], make_figure, length=31)

    def legend() -> set[str]:
        [shown] = scene.root.legends
        return {text.get_text() for text in shown.get_texts()}

    loaded = {"r robot (loaded)", "trail, empty"}
    assert not legend() & loaded
    for action in ("W", "PICK"):
        recorder.step(action)
    whole = track_of_record(recorder.episode)
    scene.show(2, whole)
    assert legend() >= loaded
    [shown] = scene.root.legends
    scene.show(2, whole)
    assert scene.root.legends == [shown], "a legend that is right is not drawn again"
    scene.show(0, start)
    assert not legend() & loaded


def test_a_still_shows_a_hit_of_one_step_the_most_pushes_or_else_the_end() -> None:
    whole = track_of_record(short_episode())
    assert (whole.still, whole.frames[1].hits != ()) == (len(whole) - 1, True)
    bump = record_of_a_bump()
    track = track_of_record(bump, frame_seconds=0.05)
    assert track.frames[track.still].hits
    assert not track.frames[track.still - 1].hits
    assert track.still < len(track) - 1
    frames = track_of_record(fleet_episode(max_steps=5)).frames
    fleets = [frame.fleet for frame in frames]
    pushed: list[dict[int, int]] = [{}, {0: 1}, {0: 1, 2: 3}, {1: 0}]
    for frame, fleet, pushers in zip(frames, fleets, pushed, strict=False):
        assert fleet is not None
        frame.fleet = fleet._replace(plans=StepPlans(pushers=pushers))
    assert Track(frames, {}).still == 2


def record_of_a_bump() -> Episode:
    """Return one step against a wall, of a body."""
    recorder = EpisodeRecorder(WarehouseEnv(ROOM, (1, 2), backend="physics"), seed=4)
    recorder.step("N")
    return recorder.episode


def test_a_scene_shows_a_track_that_has_grown() -> None:
    whole = track_of_record(short_episode())
    metrics = {name: values[:1] for name, values in whole.metrics.items()}
    start = dataclasses.replace(whole, frames=whole.frames[:1], metrics=metrics, ending="")
    scene = Scene([start], make_figure, length=31)
    assert "step 0 of 30" in [text.get_text() for text in scene.root.texts]
    before = scene.root.axes[1].get_ylim()
    scene.show(6, whole)
    words = [text.get_text() for text in scene.root.texts]
    delivered = "delivered in 6 steps; the minimum is 5"
    assert {"step 6 of 30", delivered, "DELIVERED"} <= set(words)
    low, high = scene.root.axes[1].get_ylim()
    assert low < before[0]
    assert high > 13
    scene.show(0, start)
    assert scene.root.axes[1].get_ylim() == (low, high), "the range is never narrowed"
