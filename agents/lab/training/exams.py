"""Exams of an agent during its training, which are the points of its learning curve."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from agents.lab.trials.scores import FleetScores, Scores
from agents.lab.trials.task import FleetTask, Task
from agents.learning.learner import MakeAgent
from agents.learning.q_learning import TRAINING_SEEDS
from warehouse_core.files.tables import write_table

EXAMS = 25
"""Number of exams during a training, which are evenly spaced."""

EXAM_SEEDS = range(TRAINING_SEEDS, TRAINING_SEEDS + 200)
FINAL_SEEDS = range(2 * TRAINING_SEEDS, 2 * TRAINING_SEEDS + 1000)
"""Seeds for the comparison with the greedy agent, which are used for nothing else."""


class ExamPoint(NamedTuple):
    """The scores of an agent after a number of training steps."""

    steps: int
    scores: Scores | FleetScores


class Examiner:
    """An examiner that evaluates an agent at regular intervals during its training.

    Attributes:
        points: scores of each exam.
        summary: result of the last exam in words.
    """

    def __init__(self, task: Task | FleetTask, steps: int) -> None:
        self.points: list[ExamPoint] = []
        self.summary = "-"
        self._task, self._goal = task, steps
        self._next_exam = steps / EXAMS

    def watch(self, steps: int, make_agent: MakeAgent) -> bool:
        """Examine the agent after ``steps`` training steps if an exam is due.

        Returns:
            ``True`` if there was an exam.
        """
        is_time = steps >= min(self._next_exam, self._goal)
        # A resumed training is watched again at the step where it had stopped.
        is_time &= not self.points or self.points[-1].steps < steps
        if is_time:
            scores = self._task.evaluate(make_agent, EXAM_SEEDS[:: self._task.seed_stride])
            self.points.append(ExamPoint(steps, scores))
            self.summary = scores.summary
            self._next_exam = steps + self._goal / EXAMS
        return is_time


def mean_length(scores: Scores) -> float:
    """Return the mean number of steps of all episodes, including episodes without a delivery."""
    return float(scores.lengths.mean())


def numbers(point: ExamPoint) -> dict[str, float]:
    """Return the measures of an exam by name, with the ends of a 95% interval."""
    scores = point.scores
    if isinstance(scores, FleetScores):
        name, measured = "delivered_per_hour", scores.per_hour
        others = {"blocked_by_others": scores.blocked.estimate}
    else:
        name, measured = "delivered", scores.success
        others = {"mean_episode_steps": mean_length(scores)}
    return {name: measured.estimate, "low": measured.low, "high": measured.high, **others}


def save_points(path: Path, points: Sequence[ExamPoint]) -> None:
    """Write a CSV file with a line for each point, of which there must be at least one.

    No incomplete file is left after an error.
    """
    lines = [(point.steps, *numbers(point).values()) for point in points]
    write_table(path, ("steps", *numbers(points[0])), lines)
