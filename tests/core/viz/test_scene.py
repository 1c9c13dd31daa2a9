"""The pixels and texts of a scene."""

import dataclasses
import math
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
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb

from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv
from warehouse_core.motion.base import Contact
from warehouse_core.records.plans import StepPlans
from warehouse_core.render.palette import (
    BATTERY,
    COLORS,
    ICE,
    ICE_WAVE,
    INK,
    ITEM,
    LOOK,
    PALE_WARNING,
    PAPER,
    SHADOW,
    TRAIL_COLORS,
    WARNING,
    blend,
)  # fmt: skip
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.legend import signs_of
from warehouse_core.viz.replay import Replay
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import METRICS, Pose, Track

TRAIL_STEPS = LOOK["trail"]["steps"]
BARE = ["#####", "#P.D#", "#..R#", "#####"]
REWARDS = "cumulative reward (bars: each step)"


def frames_at(*cells: tuple[int, int], robot: str = "R") -> list[list[list[str]]]:
    """Return frames of ``ROOM`` with the robot in these cells."""
    frames = []
    for row, column in cells:
        frame = [list(line) for line in ROOM.rows]
        frame[row][column] = robot
        frames.append(frame)
    return frames


def axes_titled(replay: Replay, title: str) -> Axes:
    (found,) = [axes for axes in replay.figure.axes if axes.get_title(loc="left") == title]
    return found


def titles(replay: Replay) -> list[str]:
    return [axes.get_title(loc="left") for axes in replay.figure.axes]


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
    assert {"slippery floor", "what the robot does not see"} <= {*signs}


def test_the_action_and_its_reason_are_the_largest_words() -> None:
    replay = replay_of(short_episode(reasons=["x " * 150, *["why"] * 5]))
    for frame in (1, 2):
        replay.go_to(frame)
        replay.figure.pixels()
        (said,) = [t for t in replay.figure.texts if t.get_text().startswith(("N (x", "W (why)"))]
        width = said.get_window_extent().x1
        assert width <= replay.figure.bbox.x1
    others = [text for axes in replay.figure.axes for text in axes.texts]
    sizes = [text.get_fontsize() for text in (*replay.figure.texts, *others) if text is not said]
    assert said.get_fontsize() > 1.3 * max(sizes)


def test_wide_grids_have_visible_stations() -> None:
    replay = replay_of([["." * 150, ".D" + "." * 147 + "R", "." * 150]])
    around = patch(replay, pixels(replay), 0.0, 0.0, 4.0, 2.99)
    assert count_color(around, COLORS["D"]) > 20


@pytest.mark.parametrize(("robot", "tile", "column"), [("R", "P", 1), ("r", "D", 3)])
def test_the_letter_of_a_tile_stays_readable_under_the_robot(
    robot: str, tile: str, column: int
) -> None:
    # The first frame shows what is under the robot in the second one.
    replay = replay_of(frames_at((2, 2), (1, column), robot=robot))
    corner = (column + 0.05, 1.05, column + 0.24, 1.24)
    without = patch(replay, pixels(replay), *corner)
    replay.go_to(1)
    under = patch(replay, pixels(replay), *corner)
    letter = np.abs(without - 255 * np.array(COLORS[tile])).sum(axis=2) > 30
    assert letter.sum() > 20
    assert np.array_equal(under[letter], without[letter])
    assert is_color(pixels(replay)[point_of(replay, column + 0.5, 1.92)], COLORS[tile])


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
    for frame, done in enumerate(("", "N (why not)", "W", "PICK", "E", "E", "DELIVERED")):
        replay.go_to(frame)
        assert {f"step {frame} of 6", done} - {""} <= {*texts(replay)}
        assert ("N (why not)" in texts(replay)) == (frame == 1)
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
    assert {"hit", "what the robot does not see", "trail, empty", "R robot (empty)"} <= {*words}


def test_rows_and_columns_are_numbered_from_0() -> None:
    axes = replay_of([BARE]).figure.axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["0", "1", "2", "3", "4"]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["0", "1", "2", "3"]
    wide = replay_of([["R" + "." * 40]]).figure.axes[0]
    numbers = [label.get_text() for label in wide.get_xticklabels()]
    assert numbers == [str(column) for column in range(0, 41, 5)]


# The charts.


@pytest.mark.parametrize("shown", [
    *[{name} for name in METRICS], *[{*METRICS} - {name} for name in METRICS], set()
])  # fmt: skip
def test_each_metric_has_its_chart_and_may_be_missing(shown: set[str]) -> None:
    metrics = {name: [1.0, 0.5] for name in METRICS if name in shown}
    replay = replay_of(frames_at((2, 1), (2, 2)), metrics)
    stations = " and ".join(name[5:] for name in METRICS[2:] if name in shown)
    expected = [REWARDS] * ("rewards" in shown)
    expected += [f"distance to {stations} (cells)"] * bool(stations)
    assert titles(replay) == ["", *expected, *[""] * ("battery" in shown)]
    assert any(text.startswith("battery ") for text in texts(replay)) == ("battery" in shown)
    replay.go_to(1)
    pixels(replay)


def test_both_distances_share_a_chart_in_the_colours_of_their_stations() -> None:
    replay = replay_of(short_episode())
    axes = axes_titled(replay, "distance to pickup and dropoff (cells)")
    assert [to_rgb(line.get_color()) for line in axes.lines] == [COLORS["P"], COLORS["D"]]
    assert axes.lines[0].get_linestyle() != axes.lines[1].get_linestyle()
    assert [text.get_text() for text in axes.texts] == ["P", "D"]
    replay.go_to(4)
    assert list(axes.lines[0].get_ydata()) == [1, 1, 0, 0, 1]
    assert list(axes.lines[1].get_ydata()) == [1, 1, 2, 2, 1]
    assert [text.get_position() for text in axes.texts] == [(4, 1), (4, 1)]


def test_a_distance_without_a_station_is_not_drawn() -> None:
    replay = replay_of(
        frames_at((2, 1), (2, 2)), {"dist_pickup": [None, 1.0], "dist_dropoff": [math.nan] * 2}
    )
    assert "P" not in texts(replay)
    replay.go_to(1)
    assert texts(replay).count("P") == 1
    assert "D" not in texts(replay)
    pixels(replay)


def test_rewards_are_bars_and_their_sum_is_a_line() -> None:
    replay = replay_of(short_episode())
    axes = axes_titled(replay, REWARDS)
    replay.go_to(3)
    line = axes.lines[1]
    assert list(line.get_xdata()) == [0, 1, 2, 3]
    assert list(line.get_ydata()) == pytest.approx([0, -1.1, -1.2, 3.7])
    (bars,) = [found for found in axes.collections if isinstance(found, LineCollection)]
    assert [bar[1][1] for bar in bars.get_segments()] == pytest.approx([0, -1.1, -0.1, 4.9])
    # A missing reward counts as 0.
    replay = replay_of(frames_at((2, 1), (2, 2), (2, 3)), {"rewards": [1.0, None, 2.0]})
    replay.go_to(2)
    assert list(axes_titled(replay, REWARDS).lines[1].get_ydata()) == [1, 1, 3]


def test_charts_have_room_for_the_whole_episode_from_the_first_frame() -> None:
    replay = replay_of(short_episode())
    for axes in replay.figure.axes[1:3]:
        assert axes.get_xlim()[0] < 0
        assert axes.get_xlim()[1] > 6
    reward, distance = replay.figure.axes[1:3]
    assert reward.get_ylim()[0] < -1.2
    assert reward.get_ylim()[1] > 13.2
    assert distance.get_ylim()[1] > 2


# The battery.


def battery_of(level: float | None, full: float = 100.0) -> tuple[Replay, str]:
    replay = replay_of(frames_at((2, 1), (2, 2)), {"battery": [full, level]})
    replay.go_to(1)
    (words,) = [text for text in texts(replay) if text.startswith("battery")]
    return replay, words


def color_in_the_bar(replay: Replay, share: float) -> Any:
    axes = replay.figure.axes[-1]
    column, height = axes.transData.transform((share, 0.5))
    return pixels(replay)[round(replay.figure.bbox.height) - 1 - int(height), int(column)]


@pytest.mark.parametrize(
    ("level", "full", "words"),
    [
        (100.0, 100, "battery 100 of 100"),
        (20.0, 100, "battery 20 of 100"),
        (19.9, 100, "battery 19.9 of 100  LOW!"),
        (0.0, 100, "battery 0 of 100  EMPTY!"),
        (-1.0, 100, "battery -1 of 100  EMPTY!"),
        (None, 100, "battery unknown"),
        (1_234_567, 2_000_000, "battery 1234567 of 2000000"),
    ],
)
def test_the_battery_text_gives_its_level(level: float | None, full: float, words: str) -> None:
    assert battery_of(level, full)[1] == words


def test_the_length_of_the_bar_is_the_level_of_the_battery_which_is_red_if_it_is_low() -> None:
    for level, color, paper in ((0.9, BATTERY, PAPER), (0.19, WARNING, PALE_WARNING)):
        replay, _ = battery_of(100 * level)
        for share in (0.02, level - 0.02):
            assert is_color(color_in_the_bar(replay, share), color)
        for share in (level + 0.02, 0.97):
            assert is_color(color_in_the_bar(replay, share), paper)
    replay.go_to(0)
    assert is_color(color_in_the_bar(replay, 0.1), BATTERY)


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
    delivered = "delivered in 6 steps; the shortest way takes 5"
    assert {"step 6 of 30", delivered, "DELIVERED"} <= set(words)
    low, high = scene.root.axes[1].get_ylim()
    assert low < before[0]
    assert high > 13
    scene.show(0, start)
    assert scene.root.axes[1].get_ylim() == (low, high), "the range is never narrowed"


def test_every_robot_of_a_track_is_drawn_with_its_trail() -> None:
    track = track_of_record(short_episode())
    for frame in track.frames:
        frame.robots = (*frame.robots, Pose((1.5 + 2 * (frame.progress > 0), 2.5), None, True))
    scene = Scene([track], make_figure)
    (left, bottom), (right, top) = scene.root.axes[0].transData.transform([(1, 3), (4, 2)])
    height = round(scene.root.bbox.height)
    row = slice(height - round(top), height - round(bottom)), slice(round(left), round(right))
    drawings = []
    for frame in (0, 1):
        scene.show(frame)
        drawings.append(np.asarray(scene.root.pixels()).astype(int)[row])
    assert all(count_color(image, COLORS["r"]) > 60 for image in drawings)
    assert [count_color(image, TRAIL_COLORS[True]) > 10 for image in drawings] == [False, True]
