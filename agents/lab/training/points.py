"""The points of a learning curve as numbers: a CSV file, and events for TensorBoard."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from agents.lab.console.csv_file import write_csv
from agents.lab.training.exams import ExamPoint
from agents.lab.trials.scores import FleetScores, Scores

EVENT_FILES = "events.out.tfevents.*"
"""Files that TensorBoard reads in a folder."""


def mean_length(scores: Scores) -> float:
    """Return the mean number of steps of all episodes, including those without a delivery."""
    return float(scores.lengths.mean())


def numbers(point: ExamPoint) -> dict[str, float]:
    """Return the measures of an exam by name, with the ends of 95% intervals."""
    scores = point.scores
    if isinstance(scores, FleetScores):
        name, measured = "delivered_per_hour", scores.per_hour
        others = {"blocked_by_others": scores.blocked.estimate}
    else:
        name, measured = "delivered", scores.success
        others = {"mean_episode_steps": mean_length(scores)}
    return {name: measured.estimate, "low": measured.low, "high": measured.high, **others}


def save_points(path: Path, points: Sequence[ExamPoint]) -> None:
    """Write a line for each of at least one point, whole or not at all."""
    lines = [(point.steps, *numbers(point).values()) for point in points]
    write_csv(path, ("steps", *numbers(points[0])), lines)


@contextmanager
def events(folder: Path, *, resumed: bool) -> Iterator[Callable[[ExamPoint], None]]:
    """Yield what adds a point to TensorBoard's events, if the library ``tensorboard`` is installed.

    The events of an earlier training in the folder are removed unless it is ``resumed``.
    """
    if find_spec("tensorboard") is None:
        yield lambda point: None
        return
    writer: Any = None

    def add(point: ExamPoint) -> None:
        nonlocal writer
        if writer is None:
            writer = _new_writer(folder, resumed=resumed)
        for name, value in numbers(point).items():
            writer.add_scalar(name, value, point.steps)
        writer.flush()

    try:
        yield add
    finally:
        if writer is not None:
            writer.close()


def _new_writer(folder: Path, *, resumed: bool) -> Any:
    from tensorboard.summary import Writer  # takes long to import

    if not resumed:
        for path in folder.glob(EVENT_FILES):
            path.unlink()
    return Writer(str(folder))
