"""The bar of a sweep: how many episodes, how fast, how long still, and how many deliver."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

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

from agents.experiments.running import Report
from agents.experiments.store import Row
from warehouse_core.episode import DELIVERED


class RateColumn(ProgressColumn):
    """Episodes a second, lately."""

    def render(self, task: Task) -> Text:
        """Return the rate as text."""
        return Text("" if task.speed is None else f"{task.speed:,.0f}/s")


@contextmanager
def sweep_bar(episodes: int) -> Iterator[Report]:
    """Yield what is told of rows that are stored; without a terminal there is no bar."""
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        RateColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[delivered]}"),
    )
    console = Console(stderr=True)
    counts = {"all": 0, "delivered": 0}
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task("", total=episodes, delivered="")

        def report(rows: Sequence[Row]) -> None:
            counts["all"] += len(rows)
            counts["delivered"] += sum(row.mode == DELIVERED for row in rows)
            if rows:
                share = counts["delivered"] / counts["all"]
                bar.update(task, advance=len(rows), delivered=f"{share:.0%} delivered")

        yield report
