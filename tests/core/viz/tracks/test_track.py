import dataclasses
import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from helpers.fleets import fleet_episode
from helpers.integrals import integral
from helpers.pictures import HOSTILE_NAMES, named, short_episode

from agents.run_episode import run_episode
from warehouse_core import Episode, RecordError
from warehouse_core.motion.base import Contact
from warehouse_core.records.drive_summary import drive_summary
from warehouse_core.viz.tracks.grid_track import track_of_frames
from warehouse_core.viz.tracks.record_track import Floor, frames_along, track_of_record
from warehouse_core.viz.tracks.series import series_of
from warehouse_core.viz.tracks.track import OUTER, Frame, Pose, TileRows, Track


def frame(*rows: str) -> list[list[str]]:
    return [list(row) for row in rows]


def poses(track: Track, step: int | None = None) -> list[Pose]:
    """Return the poses of the first robot, of all frames or of those within one step."""
    frames = [f for f in track.frames if step is None or step < f.progress <= step + 1]
    return [pose for pose in (each.robots[0] for each in frames) if pose]


def tiles(track: Track) -> list[TileRows]:
    return [each.tiles for each in track.frames]


def clocks(track: Track) -> list[float]:
    """Return the clock at the end of each step."""
    return [track.frames[end].clock for end in track.ends]


def captions(track: Track) -> list[str]:
    return [each.caption for each in track.frames]


# Tracks of episodes.


@pytest.mark.parametrize("name", HOSTILE_NAMES)
def test_titles_and_captions_can_be_printed(name: str) -> None:
    track = track_of_record(named(name))
    assert track.title.isprintable()
    assert all(caption.isprintable() for caption in captions(track))


def test_motions_of_too_many_frames_raise() -> None:
    episode = short_episode()
    path = np.linspace((0, 1.5, 1.5, 0), (1e12, 1.5, 1.5, 0), 3)
    episode.motions[0] = episode.motions[0]._replace(seconds=1e12, path=path)
    with pytest.raises(RecordError, match="more than MAX_FRAMES = 100000"):
        track_of_record(episode)
    assert len(track_of_record(episode, frame_seconds=1e12)) == 7


# Tracks of frames.


def test_rows_may_be_strings_and_arrays() -> None:
    rows = ["#R", ".."]
    lists = track_of_frames([frame(*rows)])
    assert track_of_frames([rows]) == lists
    assert track_of_frames(np.array([[list(row) for row in rows]])) == lists


@pytest.mark.parametrize(
    ("frames", "index", "row"),
    [
        (["R.D", "PR."], 0, "P.D"),
        (["R.D", ".RD", "..r"], 2, "..D"),
        (["R.", "r.", "Pr"], 0, "P."),
        (["R.", "r.", "Pr"], 1, "P."),
        (["#R#"], 0, "#.#"),
    ],
)
def test_the_tile_under_the_robot_is_seen_in_the_nearest_frame_or_empty(frames, index, row) -> None:
    assert tiles(track_of_frames([[each] for each in frames]))[index] == (row,)


def test_equal_tiles_are_the_same_object() -> None:
    # The drawing compares them by identity to see that nothing changed.
    track = track_of_frames(short_episode().frames)
    assert all(one is other for one, other in pairwise(tiles(track)))


def test_a_frame_may_be_without_a_robot() -> None:
    track = track_of_frames([frame("..P"), frame("R.P")])
    shown = Pose((0.5, 0.5), None, loaded=False)
    assert [each.robots for each in track.frames] == [(None,), (shown,)]


TWO = [["R."], [".R"]]


@pytest.mark.parametrize(
    ("frames", "metrics", "message"),
    [
        ([["###", "#R#"], ["###", "#R?"]], {}, "frame 1, row 1, column 2: '.' is unknown; allowed"),
        ([["##", "#"]], {}, "frame 0 has 2 rows with 1 columns in row 1; frame 0 has 2 rows of 2"),
        ([["##"], ["#"]], {}, "frame 1 has 1 rows with 1 columns in row 0; frame 0 has 1 rows of"),
        ([["##"], []], {}, "frame 1 has no rows"),
        ([[]], {}, "frame 0 has no rows"),
        ([[""]], {}, "frame 0 has 1 rows with 0 columns in row 0"),
        (TWO, {"battery": [1.0]}, "'battery' has 1 entries for 2 frames"),
        (TWO, {"reward": [0.0] * 2}, "'reward' is unknown; allowed: rewards, battery, dist_"),
        (TWO, {"battery": [3.0, -math.inf]}, "metric 'battery', frame 1: -inf is not a finite num"),
        (TWO, {"battery": [3.0, "a"]}, "frame 1: 'a' is not a finite number, None or NaN"),
    ],
)
def test_bad_frames_and_metrics_are_named(frames: Any, metrics: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        track_of_frames(frames, metrics)


def test_none_and_nan_are_not_plotted() -> None:
    metrics = {"dist_pickup": [None, math.nan, np.float64(2.0)]}
    track = track_of_frames([frame("R."), frame(".R"), frame("R.")], metrics)
    assert np.isnan(track.metrics["dist_pickup"]).tolist() == [True, True, False]
    assert track.metrics["dist_pickup"][2] == 2


def test_the_fullest_battery_counts_as_full() -> None:
    for levels, full in (([7, 9], 9), ([None, 9], 9), ([0, 0], 1)):
        assert track_of_frames(TWO, {"battery": levels}).full_battery == full
    assert track_of_frames(TWO).full_battery == 1


# Tracks of continuous motions.


DRY = Floor(1.0, np.zeros((3, 5), bool))


def straight_on(seconds: float = 2.0) -> np.ndarray:
    """Return a path of 1 m to the east at constant speed, with a row every 0.1 s."""
    times = np.linspace(0, seconds, 21)
    return np.column_stack([times, 2.5 + times / seconds, np.full(21, 1.5), np.zeros(21)])


def continuous_track(frame_seconds: float = 0.5):
    episode = short_episode()
    contact = Contact(1.0, 28.4, (3.5, 1.5), "wall")
    moving = episode.motions[3]._replace(
        seconds=2.0, joules=100.0, path=straight_on(), contacts=(contact,)
    )
    motions = [*episode.motions[:3], moving, *episode.motions[4:]]
    return track_of_record(dataclasses.replace(episode, motions=motions), frame_seconds)


def test_the_clock_and_energy_run_through_all_motions_and_without_readings_in_steps() -> None:
    track = continuous_track()
    assert clocks(track) == pytest.approx([0, 1, 2, 3, 5, 6, 7])
    assert all(a.clock < b.clock for a, b in pairwise(track.frames))
    joules = [motion.joules for motion in short_episode().motions]
    assert track.frames[-1].energy == pytest.approx(sum(joules) - joules[3] + 100.0)
    inside = [each.energy for each in track.frames if 3 <= each.progress <= 4]
    assert np.diff(inside) == pytest.approx([0, 0, 0, 100])
    titles = {series.chart for series in series_of(track, [each.clock for each in track.frames])}
    assert "Energy used (J)" in titles
    assert "Speed (m/s)" not in titles, "a speed is measured, not a difference of positions"


@pytest.mark.parametrize("record", [short_episode(), fleet_episode(max_steps=2)])
@pytest.mark.parametrize("seconds", [0.0, -1.0, math.nan])
def test_the_time_between_frames_must_be_positive(record: Episode, seconds: float) -> None:
    with pytest.raises(ValueError, match="frame_seconds is"):
        track_of_record(record, seconds)


def test_frames_of_two_robots_have_the_poses_of_both_and_a_common_hit_once() -> None:
    contact = Contact(0.5, 10.0, (3.0, 1.5), "robot 1")
    east = short_episode().motions[3]._replace(seconds=2.0, path=straight_on(), contacts=(contact,))
    west = east._replace(
        path=east.path[:, [0, 1, 2, 3]] * (1, -1, 1, 1) + (0, 7, 0, math.pi),
        contacts=(contact._replace(counterpart="robot 0"),),
    )
    start = Frame((".....",), (Pose((2.5, 1.5), None, False), Pose((4.5, 1.5), None, True)), 3.0)
    frames = list(frames_along(start, [east, west], [True, False], DRY, 1.0, "both"))
    assert [frame.progress for frame in frames] == [3.5, 4.0]
    found = [[pose.at[0] for pose in frame.robots if pose] for frame in frames]
    assert found == [pytest.approx([3.0, 4.0]), pytest.approx([3.5, 3.5])]
    loaded = [[pose.loaded for pose in frame.robots if pose] for frame in frames]
    assert loaded == [[False, True], [True, False]]
    assert [len(frame.hits) for frame in frames] == [1, 0]


# What is shown of the map.


@pytest.mark.parametrize(
    ("rows", "outer"),
    [
        (["###", "#.#", "###"], OUTER),
        (["#?#", "#.#", "??#"], OUTER),
        (["###", "#.P", "###"], 0.0),
        (["#.#", "#.#", "###"], 0.0),
        (["##", "##"], 0.0),
    ],
)
def test_a_border_of_walls_is_not_shown_whole(rows: list[str], outer: float) -> None:
    frames = [Frame(tuple(each), (), 0.0) for each in (rows, ["###"] * 3)]
    assert Track(frames[:1], {}).outer == Track(frames, {}).outer == outer
    assert Track(frames[:1], {}).shown_size == (len(rows[0]) - 2 * outer, len(rows) - 2 * outer)


# Bodies.


def test_speeds_of_a_chart_add_up_to_the_distance_and_contain_their_extremes() -> None:
    for backend in ("physics", "physics:drive=differential", "physics:grip=0.05"):
        record = run_episode(backend=backend, seed=12, max_steps=40)
        track, summary = track_of_record(record), drive_summary(record)
        assert summary is not None
        speed, force, energy = [*series_of(track, [each.clock for each in track.frames])][-3:]
        assert (speed.chart, force.chart) == ("Speed (m/s)", "Motor force (N)")
        assert integral(speed.values, speed.times) == pytest.approx(summary.distance, rel=0.01)
        assert max(speed.values) == summary.top_speed
        assert energy.values[-1] == pytest.approx(record.joules)


def test_a_body_that_rolls_over_slippery_floor_with_little_force_does_not_skid() -> None:
    path = straight_on()
    readings = np.zeros((len(path), 5))
    readings[:, 0], readings[:, 2] = 0.5, np.where(path[:, 0] < 1.05, 100.0, 7.0)
    motion = short_episode().motions[3]._replace(seconds=2.0, path=path, readings=readings)
    start = Frame((".....",), (Pose((2.5, 1.5), None, False),), 0.0)
    wet = Floor(1.0, np.ones((3, 5), bool), (100.0, 50.0))
    for floor, is_loaded, expected in ((wet, False, 5), (wet, True, 5), (DRY, False, 0)):
        frames = [*frames_along(start, [motion], [is_loaded], floor, 0.2, "")]
        pushes = [frame.robots[0].push for frame in frames if frame.robots[0]]
        assert [push.skids for push in pushes if push] == [True] * expected + [False] * (
            10 - expected
        )


def test_a_step_without_duration_has_one_frame() -> None:
    path = np.array([(0, 2.5, 1.5, 0), (0, 2.5, 1.5, 0)], float)
    bump = short_episode().motions[3]._replace(seconds=0.0, joules=0.0, path=path)
    start = Frame((".....",), (Pose((2.5, 1.5), None, False),), 3.0, clock=5.0)
    for motion in (bump, bump._replace(readings=np.zeros((2, 5)))):
        [frame] = frames_along(start, [motion], [False], DRY, 0.2, "a bump left out")
        assert (frame.progress, frame.clock, frame.energy) == (4.0, 5.0, 0.0)
        assert [pose.at for pose in frame.robots if pose] == [(2.5, 1.5)]


def test_a_path_from_a_file_may_lead_off_the_floor() -> None:
    record = run_episode(backend="physics:slippery=5-4,grip=0.05", seed=12, max_steps=3)
    far = np.add(record.motions[1].path, (0, 1e9, -1e9, 0))
    motions = [record.motions[0], record.motions[1]._replace(path=far), *record.motions[2:]]
    track = track_of_record(dataclasses.replace(record, motions=motions))
    assert max(pose.at[0] for pose in poses(track)) > 1e8
