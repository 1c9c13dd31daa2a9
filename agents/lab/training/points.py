"""The points of a learning curve as a CSV file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from agents.lab.training.exams import ExamPoint
from agents.lab.trials.scores import FleetScores, Scores
from warehouse_core.files.tables import write_table


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
    """Write a line for each point, of which there must be at least one.

    No incomplete file is left after an error.
    """
    lines = [(point.steps, *numbers(point).values()) for point in points]
    write_table(path, ("steps", *numbers(points[0])), lines)
