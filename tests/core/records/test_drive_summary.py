"""Summaries of what bodies measured in an episode."""

from typing import Any

import numpy as np
import pytest

from agents import GreedyAgent
from warehouse_core import EpisodeRecorder, FleetEnv, Layout, WarehouseEnv, record_episode
from warehouse_core.records import Episode, FleetRecorder
from warehouse_core.records.drive_summary import drive_summary

AISLE = Layout(["P..D"])


def driven(*actions: str, backend: Any = "physics", layout: Layout = AISLE) -> Episode:
    env = WarehouseEnv(layout, (0, 0), backend=backend)
    env.reset()
    recorder = EpisodeRecorder(env)
    for action in actions:
        recorder.step(action)
    return recorder.episode


def test_a_body_stops_at_the_end_of_each_move_however_long_it_rests_there() -> None:
    summary = drive_summary(driven("WAIT", "E", "WAIT", "WAIT", "E", "E", "WAIT"))
    assert summary is not None
    assert (summary.stops, summary.hits, summary.largest_impulse) == (3, 0, 0.0)
    assert summary.distance == pytest.approx(3, abs=0.01)
    assert summary.top_speed == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("drive", ["omnidirectional", "differential"])
def test_the_distance_is_the_integral_of_the_speed(drive: str) -> None:
    env = WarehouseEnv(backend=f"physics:drive={drive}")
    episode = record_episode(env, GreedyAgent(seed=12), seed=12)
    summary = drive_summary(episode)
    assert summary is not None
    along = 0.0
    for motion in episode.motions:
        speeds = np.hypot(*motion.readings[:, :2].T)
        along += float((np.diff(motion.path[:, 0]) * (speeds[1:] + speeds[:-1]) / 2).sum())
    assert summary.distance == pytest.approx(along, rel=0.01)
    assert summary.stops == 21


def test_there_is_nothing_to_sum_up_without_readings() -> None:
    assert drive_summary(driven("E", backend="grid")) is None
    assert drive_summary(driven()) is None
    fleet = FleetEnv(robots=2, orders=0.2, max_steps=3, backend="physics", seed=1)
    recorder = FleetRecorder(fleet, seed=1)
    recorder.step(["WAIT"] * 2)
    assert drive_summary(recorder.episode) is None
