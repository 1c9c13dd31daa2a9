"""The pixels and texts of a scene."""

from helpers.fleets import fleet_episode
from helpers.pictures import ROOM, short_episode

from warehouse_core import Episode, EpisodeRecorder, WarehouseEnv
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.figure import make_figure
from warehouse_core.viz.scene import Scene
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.viz.tracks.track import Track

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
