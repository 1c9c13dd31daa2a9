"""The pixels and texts of a fleet's scene."""

import pytest
from helpers.fleets import fleet_episode
from helpers.pictures import pixels, replay_of, texts

from warehouse_core import FleetEpisode


@pytest.fixture(scope="module")
def episode() -> FleetEpisode:
    return fleet_episode()


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
