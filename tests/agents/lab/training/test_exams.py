import pytest

from agents.lab.training import exams
from agents.lab.training.exams import EXAM_SEEDS, EXAMS, FINAL_SEEDS, Examiner
from agents.lab.trials.task import Task
from agents.learning.q_learning import TRAINING_SEEDS
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
