from pathlib import Path

import pytest
from helpers.results_files import BAD, row, scores_of

from agents.lab.training import exams
from agents.lab.training.exams import (
    EXAM_SEEDS,
    EXAMS,
    FINAL_SEEDS,
    Examiner,
    ExamPoint,
    numbers,
    save_points,
)
from agents.lab.trials.scores import FleetScores
from agents.lab.trials.task import FleetTask, Task
from agents.learning.q_learning import TRAINING_SEEDS
from agents.registry import make_team
from agents.warehouse_agent_greedy import GreedyAgent


@pytest.fixture(autouse=True)
def three_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exams, "EXAM_SEEDS", EXAM_SEEDS[:3])


def examined(goal: int, steps: range) -> Examiner:
    examiner = Examiner(Task(max_steps=40), goal)
    assert examiner.summary == "-"
    for taken in steps:
        examiner.watch(taken, GreedyAgent)
    return examiner


def test_exams_are_evenly_spaced_and_the_last_one_is_at_the_end() -> None:
    examiner = examined(1000, range(0, 1011, 10))
    assert [point.steps for point in examiner.points] == [*range(40, 1001, 40), 1010]
    assert len(examiner.points) == EXAMS + 1
    assert all(len(point.scores.rows) == 3 for point in examiner.points)
    assert examiner.summary == examiner.points[-1].scores.summary


def test_a_short_training_has_one_exam() -> None:
    assert [point.steps for point in examined(1, range(0, 8193, 8192)).points] == [8192]


def test_seeds_of_training_exams_and_comparison_differ() -> None:
    assert min(EXAM_SEEDS) >= TRAINING_SEEDS
    assert min(FINAL_SEEDS) >= TRAINING_SEEDS
    assert not set(EXAM_SEEDS) & set(FINAL_SEEDS)
    assert len(FINAL_SEEDS) >= 1000


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
