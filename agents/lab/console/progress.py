"""Progress of long commands on standard error: a bar, or one line a minute without a terminal."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from typing import TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from agents.lab.console.terminal import say
from warehouse_core.wording import printable

LINE_SECONDS = 60.0
"""Time between two lines of progress, used if no bar can be drawn."""

Item = TypeVar("Item")


def has_live_terminal() -> bool:
    """Return whether standard error is a terminal on which a line can be redrawn.

    Commands in the cells of a notebook also have a terminal, but it keeps everything they print.
    """
    return sys.stderr.isatty() and "JPY_PARENT_PID" not in os.environ


@contextmanager
def progress_bar(total: int, label: str = "") -> Iterator[Callable[..., None]]:
    """Yield a function that shows how much is completed while the block runs, and some news.

    Args:
        total: amount of work.
        label: text before the bar.
    """
    columns = (
        TextColumn("{task.description}", markup=False),  # it may be the name of an agent
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[news]}"),
    )
    console = Console(stderr=True)
    # Before version 14.3, Rich writes a line end even for a disabled bar.
    if not (has_live_terminal() and console.is_terminal):
        yield _lines(total, label)
        return
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(printable(label), total=total, news="")

        def advance(completed: int, news: str = "") -> None:
            bar.update(task, completed=completed, news=news)

        yield advance


def _lines(total: int, label: str) -> Callable[..., None]:
    """Return a function that prints a line if the previous line is ``LINE_SECONDS`` old."""
    started = shown = time.monotonic()

    def advance(completed: int, news: str = "") -> None:
        nonlocal shown
        now = time.monotonic()
        if now - shown < LINE_SECONDS:
            return
        shown = now
        done = f"{completed:,} of {total:,} in {timedelta(seconds=int(now - started))}"
        name = f"{label}: " if label else ""
        say(name + ", ".join(filter(None, (done, news))), error=True)

    return advance


def track(items: Sequence[Item], label: str) -> Iterator[Item]:
    """Yield ``items``, and show in a bar how many of them are done."""
    with progress_bar(len(items), label) as advance:
        for number, item in enumerate(items, start=1):
            yield item
            advance(number)
