"""The progress bar of long commands, on standard error and only if that is a live terminal."""

from __future__ import annotations

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

from warehouse_core.viz.export import has_live_terminal
from warehouse_core.wording import printable

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
    """Show a bar while the block runs, and yield what shows how much is completed, and news."""
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
        yield _show_nothing
        return
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(printable(label), total=total, news="")

        def advance(completed: int, news: str = "") -> None:
            bar.update(task, completed=completed, news=news)

        yield advance


def _show_nothing(completed: int, news: str = "") -> None:
    pass


def track(items: Sequence[Item], label: str) -> Iterator[Item]:
    """Yield ``items`` and show a bar of how many are done."""
    with progress_bar(len(items), label) as advance:
        for number, item in enumerate(items, start=1):
            yield item
            advance(number)
