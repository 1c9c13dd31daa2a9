"""What every training shares: a bar, examinations, the files it leaves, and the comparison."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from agents.console.progress import Advance, progress_bar
from agents.evaluation.samples import FIRST_EXAM_SEED, MakeAgent, Scores, Task, evaluate
from agents.learning.curve import Point, save_learning_curve
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core.errors import FormatError
from warehouse_core.files.atomic import check_target

EXAMS = 25
"""Examinations on the way, evenly spread, which are the points of the learning curve."""

EXAM_SEEDS = range(FIRST_EXAM_SEED, FIRST_EXAM_SEED + 200)
FINAL_SEEDS = range(2 * FIRST_EXAM_SEED, 2 * FIRST_EXAM_SEED + 1000)
"""Starts of the comparison with the greedy agent; none of them decides anything before it."""

MODEL_SUFFIX, CURVE_SUFFIX = ".npz", ".png"

Writer = Callable[[Path], None]


class Training:
    """Watches an agent learn, and keeps what comes of it.

    Args:
        name: of what learns.
        task: that it learns.
        steps: of the whole training.
        seed: of the training.
        output: the file of the agent; a picture of how it learnt goes beside it.

    Raises:
        FormatError: ``output`` is no ``.npz``.
    """

    def __init__(self, name: str, task: Task, steps: int, seed: int, output: Path) -> None:
        if output.suffix != MODEL_SUFFIX:
            raise FormatError(
                f"{output}: cannot save as {output.suffix or 'a file without a suffix'}; "
                f"allowed: {MODEL_SUFFIX}"
            )
        self._name, self._task, self._goal, self._seed = name, task, steps, seed
        self._output = output
        self._points: list[Point] = []
        self._next_exam = steps / EXAMS
        self._advance: Advance = lambda *_: None

    def watch(self, steps: int, delivers: float, make_agent: MakeAgent) -> None:
        """Look at the learner, which calls this every now and then and at its end.

        Args:
            steps: taken so far.
            delivers: share of the latest episodes that ended with the delivery, NaN without any.
            make_agent: makes the agent as it is now.
        """
        if steps >= min(self._next_exam, self._goal):
            self._points.append(Point(steps, evaluate(make_agent, self._task, EXAM_SEEDS)))
            self._next_exam = steps + self._goal / EXAMS
        examined = self._points[-1].scores.success if self._points else math.nan
        self._advance(steps, f"delivers {_share(delivers)}, exam {_share(examined)}")

    def run(self, learn: Callable[[], MakeAgent], writers: Mapping[str, Writer]) -> None:
        """Let an agent learn, write its files, and compare it with the greedy agent.

        An interrupt ends the training; what has been learnt by then is written all the same, once
        there has been an examination.

        Args:
            learn: trains, calls ``watch``, and returns what makes the agent.
            writers: of the files of the agent, by suffix.

        Raises:
            OSError: a file cannot be written; where its folder is missing, before the training.
        """
        for suffix in (*writers, CURVE_SUFFIX):
            check_target(self._output.with_suffix(suffix))
        greedy = evaluate(GreedyAgent, self._task, FINAL_SEEDS)
        started = time.perf_counter()

        def keep() -> None:
            if self._points:
                self._report(time.perf_counter() - started)
                self._write({**writers, CURVE_SUFFIX: lambda path: self._draw(path, greedy)})

        try:
            with progress_bar(self._goal, self._name) as self._advance:
                make_agent = learn()
        except KeyboardInterrupt:
            keep()
            raise
        keep()
        scores = evaluate(make_agent, self._task, FINAL_SEEDS)
        Console().print(comparison_table({self._name: scores, "greedy": greedy}))

    def _report(self, seconds: float) -> None:
        steps = self._points[-1].steps
        of = "" if steps >= self._goal else f" of {self._goal:,}"
        typer.echo(f"{steps:,}{of} steps in {seconds:.1f} s, seed {self._seed}")

    def _draw(self, path: Path, greedy: Scores) -> None:
        title = f"Learning to deliver: {self._name}, seed {self._seed}"
        save_learning_curve(path, self._name, title, self._points, greedy)

    def _write(self, writers: Mapping[str, Writer]) -> None:
        for suffix, write in writers.items():
            target = self._output.with_suffix(suffix)
            write(target)
            typer.echo(f"saved {target}")


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.0%}"


def comparison_table(scores: dict[str, Scores]) -> Table:
    """Return the table of how agents did on the same starts."""
    each = list(scores.values())
    table = Table(title=f"{len(each[0].steps):,} random starts, the same for each")
    table.add_column("")
    for name in scores:
        table.add_column(name, justify="right")
    by_all = np.all([one.delivered for one in each], axis=0)
    table.add_row("delivered", *(f"{one.success:.1%}" for one in each))
    table.add_row("steps to deliver", *(f"{one.steps_to_deliver():.2f}" for one in each))
    table.add_row("  where all deliver", *(f"{one.steps_to_deliver(by_all):.2f}" for one in each))
    return table
