"""The pixels and texts of a fleet's scene."""

import pytest
from helpers.fleets import SHELVES, fleet_episode
from helpers.pictures import count_color, patch, pixels, replay_of, texts

from warehouse_core import FleetEpisode, Layout, shelf_layout
from warehouse_core.render.palette import COLORS, PAPER
from warehouse_core.viz.replay import replay_of_tracks
from warehouse_core.viz.tracks.track import FleetFrame, Frame, Pose, Track


@pytest.fixture(scope="module")
def episode() -> FleetEpisode:
    return fleet_episode()


@pytest.mark.parametrize(
    ("robots", "side", "legible"), [(1, 6, True), (50, 40, True), (9, 200, False)]
)
def test_numbers_are_drawn_if_they_are_legible(robots: int, side: int, legible: bool) -> None:
    poses = tuple(Pose((robot % side + 0.5, 0.5), 0.0, False) for robot in range(robots))
    fleet = FleetFrame((), (None,) * robots, (1.0,) * robots)
    track = Track([Frame(("." * side,) * 4, poses, 0.0, fleet=fleet)], {})
    replay = replay_of_tracks(track, window=False)
    image = pixels(replay)
    # A line of pixels at the edge of the floor may be paper.
    row = patch(replay, image, 0.2, 0.2, min(robots, side) - 0.2, 0.8)
    assert (count_color(row, PAPER) > 5 * robots) == legible
    assert count_color(row, COLORS["R"]) > 5 * robots


@pytest.mark.parametrize(("robots", "layout"), [
    (50, shelf_layout(6, 6, 5, aisle=2, chargers=3)),
    (4, SHELVES),
    (2, Layout(["P.D.C"])),
])  # fmt: skip
def test_a_fleet_fits_a_small_screen_and_its_legend_has_room_below(robots, layout) -> None:
    replay = replay_of(fleet_episode(layout=layout, robots=robots, max_steps=2, people=0))
    replay.figure.pixels()
    assert replay.figure.bbox.width <= 1366
    assert replay.figure.bbox.height <= 660, "a screen of 768 pixels has bars of its own"
    (legend,) = replay.figure.legends
    below = legend.get_window_extent()
    assert replay.figure.bbox.x0 < below.x0 < below.x1 <= replay.figure.bbox.x1 + 1
    for axes in replay.figure.axes:
        # Numbers of robots, which are shapes, would count as far outside of the map.
        box = axes.get_tightbbox() if axes.get_title(loc="left") else axes.bbox
        assert box is not None
        assert not box.overlaps(below), axes.get_title(loc="left")


def test_fleets_are_shown_beside_each_other(episode: FleetEpisode) -> None:
    replay = replay_of(episode, beside=fleet_episode(seed=6))
    replay.go_to(5)
    pixels(replay)
    titles = [axes.get_title(loc="left") for axes in replay.figure.axes]
    assert titles.count("Orders: released (thin), delivered") == 2
    ends = [text[-6:] for text in texts(replay) if "backend" in text]
    assert ends == ["seed 5", "seed 6"]
    replay.show_still()
    assert any(text.endswith(": 5 delivered, 80 steps") for text in texts(replay))
