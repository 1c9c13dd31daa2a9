"""The progress bar of a training."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class Advance(Protocol):
    """Moves a bar."""

    def __call__(self, steps: int, delivers: float, examined: float) -> None:
        """Say how far the training is.

        Args:
            steps: taken so far.
            delivers: share of the latest episodes that ended with the delivery, NaN without any.
            examined: the same at the last examination.
        """


class _SpeedColumn(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(
            "" if task.speed is None else f"{task.speed:,.0f} steps/s", "progress.data.speed"
        )


@contextmanager
def training_bar(label: str, steps: int) -> Iterator[Advance]:
    """Yield what moves a bar on standard error; there is none where that is no terminal."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TaskProgressColumn(),
        _SpeedColumn(),
        TimeRemainingColumn(),
        TextColumn("left, {task.fields[news]}"),
    )
    console, quiet = Console(stderr=True), not sys.stderr.isatty()
    with Progress(*columns, console=console, transient=True, expand=True, disable=quiet) as bar:
        task = bar.add_task(label, total=steps, news="")

        def advance(steps: int, delivers: float, examined: float) -> None:
            news = f"delivers {_share(delivers)}, exam {_share(examined)}"
            bar.update(task, completed=steps, news=news)

        yield advance


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.0%}"
