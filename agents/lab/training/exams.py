"""Exams of an agent during its training, which are the points of its learning curve."""

from __future__ import annotations

from typing import NamedTuple

from agents.lab.trials.scores import FleetScores, Scores
from agents.lab.trials.task import FleetTask, Task
from agents.learning.learner import MakeAgent
from agents.learning.q_learning import TRAINING_SEEDS

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
