"""The points of a learning curve as CSV."""

from pathlib import Path

from helpers.results_files import BAD, row, scores_of

from agents.lab.training.exams import ExamPoint
from agents.lab.training.points import numbers, save_points
from agents.lab.trials.scores import FleetScores
from agents.lab.trials.task import FleetTask
from agents.registry import make_team

HALF = ExamPoint(500, scores_of([row(0, steps=14), BAD]))
ALL = ExamPoint(1000, scores_of([row(0, steps=14)] * 2))


def test_a_line_has_the_share_its_interval_and_the_mean_of_all_lengths(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    save_points(path, [HALF, ALL])
    header, first, second = path.read_text().splitlines()
    assert header == "steps,delivered,low,high,mean_episode_steps"
    low, high = HALF.scores.success[1:]  # type: ignore[union-attr]
    assert first == f"500,0.5,{low},{high},107.0"
    assert second.startswith("1000,1.0,")


def test_the_points_of_a_fleet_have_its_deliveries_per_hour() -> None:
    scores = FleetTask(robots=2, max_steps=50).evaluate_fleet(
        lambda seed: make_team("greedy", 2, seed), range(3)
    )
    assert isinstance(scores, FleetScores)
    found = numbers(ExamPoint(1, scores))
    assert list(found) == ["delivered_per_hour", "low", "high", "blocked_by_others"]
    assert found["delivered_per_hour"] == 144.0
