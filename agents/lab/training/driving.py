"""Training of continuous control by ``warehouse train drive``, with its exam."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

from agents.lab.console.table import TextTable
from agents.lab.console.terminal import say
from warehouse_core import Layout
from warehouse_core.files.atomic import check_target

EXAM_EPISODES, EXAM_SEED = 300, 10_000_000
"""Episodes of the exam, and the seed of the first one. No training uses these seeds."""


def train_drive(layout: Layout, steps: int, seed: int, target: Path) -> TextTable:
    """Train a network that controls a body, write its file, and return the table of its exam.

    An interrupt ends the training; the file is then written nevertheless.
    """
    # Here, because they take long to import.
    from agents.lab.console.progress import progress_bar
    from agents.learning.drive_training import DriveLearner, exam

    check_target(target)
    learner, started = DriveLearner(layout, steps, seed), time.perf_counter()
    try:
        with progress_bar(steps, "drive") as show:
            learner.learn(lambda done, share: show(done, f"delivers {known(share)}"))
    finally:
        learner.save(target)
        say(f"{time.perf_counter() - started:.0f} s, seed {seed}")
        say(f"saved {target}")
    results = exam(learner.network(), layout, EXAM_EPISODES, EXAM_SEED)
    return exam_table(results)


def exam_table(results: dict[str, Any]) -> TextTable:
    """Return the table of what ``exam`` returns."""
    done = results["delivered"] > 0
    rows: list[tuple[str, ...]] = [("delivered", f"{done.mean():.1%}")]
    if done.any():
        rows += [
            (f"{name} of deliveries", f"{results[name][done].mean():,.1f}")
            for name in ("seconds", "joules")
        ]
    rows.append(("impulse of hits (N·s)", f"{results['impulse'].mean():.1f}"))
    return TextTable(("", "drive"), rows, f"{len(done)} unseen episodes")


def known(share: float) -> str:
    """Return a share in percent, or a dash if it is not known yet."""
    return "-" if math.isnan(share) else f"{share:.0%}"
