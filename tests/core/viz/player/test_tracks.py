import pytest
from helpers.fleets import fleet_episode
from helpers.player import said_by

from agents.run_episode import run_episode
from warehouse_core.records.plans import StepPlans
from warehouse_core.viz.player import player_page
from warehouse_core.viz.tracks import track_of_record


def test_a_page_has_the_plans_of_each_frame() -> None:
    episode = fleet_episode(max_steps=3)
    width = episode.layout.width
    way, wish = [(1, 1), (1, 2)], [(1, 2), (2, 2), (2, 3)]
    plans = [StepPlans({0: way}), StepPlans({1: way}, {1: wish}, {2: 3})]
    page = player_page([track_of_record(episode, plans=plans)])
    fleet = said_by(page)["tracks"][0]["fleet"]
    # Frames, robots, whether they are ways or wishes, and lengths; then frame, robot and pusher.
    assert fleet["plans"] == [0, 1, 1, 0, 1, 1, 0, 0, 1, 2, 2, 3]
    assert fleet["ways"] == [row * width + col for row, col in (*way, *way, *wish)]
    assert fleet["pushes"] == [1, 2, 3]


def test_a_page_of_a_body_charts_its_speed_at_every_frame() -> None:
    track = track_of_record(run_episode(backend="physics", seed=12))
    charts = {each["title"]: each["series"] for each in said_by(player_page([track]))["charts"]}
    [speed] = charts["Speed (m/s)"]
    assert speed["x"] == pytest.approx([frame.clock for frame in track.frames], abs=1e-3)
    assert speed["y"] == pytest.approx([frame.speed for frame in track.frames], abs=1e-3)
    assert max(speed["y"]) > 0.5
