"""The progress of long commands on standard error: a bar, or a line a minute without a terminal."""

from __future__ import annotations

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
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from agents.lab.console.terminal import say
from warehouse_core.viz.export import has_live_terminal
from warehouse_core.wording import printable

LINE_SECONDS = 60.0
"""Time between two lines where no bar can be drawn."""

Item = TypeVar("Item")


class _RateColumn(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(rate_of(task.speed), "progress.data.speed")


class _TimeColumn(TimeRemainingColumn):
    """Time that is left; until that is known, time that has passed, which shows that all runs."""

    def render(self, task: Task) -> Text:
        if task.finished or task.time_remaining is not None:
            return super().render(task)
        passed = timedelta(seconds=int(task.elapsed or 0))
        return Text(f"{passed} so far", "progress.remaining")


def rate_of(speed: float | None) -> str:
    """Return how many are completed in a second, or the seconds for one; "" if it is not known."""
    if not speed:
        return ""
    return f"{speed:,.0f}/s" if speed >= 1 else f"1 in {1 / speed:,.1f} s"


@contextmanager
def progress_bar(total: int, label: str = "") -> Iterator[Callable[..., None]]:
    """Yield what shows, while the block runs, how much is completed, and news."""
    columns = (
        TextColumn("{task.description}", markup=False),  # it may be the name of an agent
        BarColumn(),
        MofNCompleteColumn(),
        _RateColumn(),
        _TimeColumn(),
        TextColumn("{task.fields[news]}"),
    )
    console = Console(stderr=True)
    # Before 14.3 Rich writes a line end even for a disabled bar.
    if not (has_live_terminal() and console.is_terminal):
        yield _lines(total, label)
        return
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(printable(label), total=total, news="")

        def advance(completed: int, news: str = "") -> None:
            bar.update(task, completed=completed, news=news)

        yield advance


def _lines(total: int, label: str) -> Callable[..., None]:
    """Return what prints a line if the last one is ``LINE_SECONDS`` old."""
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
    """Yield ``items`` and show a bar of how many are done."""
    with progress_bar(len(items), label) as advance:
        for number, item in enumerate(items, start=1):
            yield item
            advance(number)
