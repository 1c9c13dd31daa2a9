import math
from typing import Any

import pytest
from helpers.fleets import fleet_episode
from helpers.player import said_by

from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.player import player_page
from warehouse_core.viz.player.tracks import Columns
from warehouse_core.viz.tracks import Track, track_of_record


@pytest.fixture(scope="module")
def track() -> Track:
    """Return the track of a short fleet."""
    return track_of_record(fleet_episode(max_steps=3))


def test_a_page_has_the_plans_of_each_frame() -> None:
    episode = fleet_episode(max_steps=3)
    width = episode.layout.width
    path, wish = [(1, 1), (1, 2)], [(1, 2), (2, 2), (2, 3)]
    plans = [StepPlans({0: path}), StepPlans({1: path}, {1: wish}, {2: 3})]
    page = player_page([track_of_record(episode, plans=plans)])
    fleet = said_by(page)["tracks"][0]["fleet"]
    assert fleet["plans"] == {
        "frame": [0, 1, 1], "robot": [0, 1, 1], "isWish": [0, 0, 1], "end": [2, 4, 7],
    }  # fmt: skip
    assert fleet["paths"] == [row * width + col for row, col in (*path, *path, *wish)]
    assert fleet["pushes"] == {"frame": [1], "robot": [2], "pusher": [3]}


@pytest.mark.parametrize("opens_at", [None, 0.0, 61.5])
def test_a_page_says_when_it_opens_or_that_it_plays(opens_at, track) -> None:
    assert said_by(player_page([track], opens_at=opens_at))["opensAt"] == opens_at


@pytest.mark.parametrize("opens_at", [-0.1, math.nan, math.inf, "1"])
def test_a_page_that_is_to_open_at_no_moment_is_refused(opens_at: Any, track: Track) -> None:
    with pytest.raises(ValueError, match="opens_at is"):
        player_page([track], opens_at=opens_at)


@pytest.mark.parametrize("values", [[2**31 - 0.4], [0, 2**31 - 1, -1], [math.nan], [math.inf] * 2])
def test_numbers_or_differences_that_32_bits_cannot_hold_are_refused(values: list[float]) -> None:
    with pytest.raises(ValueError, match="32 bits"):
        Columns().whole(values, is_delta=True)
