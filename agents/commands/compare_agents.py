"""The chapter's agent beside those that search, over the same seeds: a table and a figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from agents.console.options import (
    BackendOption,
    BatteryOption,
    LayoutOption,
    MaxStepsOption,
    load_layout,
)
from agents.evaluation.scores import CONTENDERS, MEASURES, Run, Scores, Task, run_agent
from agents.evaluation.wording import mean, share
from warehouse_core.files.atomic import atomic_path, check_target
from warehouse_core.viz.export import check_suffix, save_svg
from warehouse_core.wording import counted

PICTURES = (".svg", ".png")


def compare_agents(
    episodes: Annotated[
        int, typer.Option("--episodes", "-n", min=1, max=100_000, help="Of each agent.")
    ] = 100,
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", min=0, help="Of the first episode.")
    ] = 0,
    backend: BackendOption = "physics",
    layout: LayoutOption = None,
    battery: BatteryOption = 200,
    max_steps: MaxStepsOption = 200,
    save: Annotated[
        Path | None, typer.Option("--save", metavar="FILE", help="Write the figure, .svg or .png.")
    ] = None,
) -> None:
    """Compare the greedy agent, the exploring one and search over the same seeds."""
    if save is not None:
        check_suffix(save, PICTURES)
        check_target(save)
    task = Task(load_layout(layout), backend, battery, max_steps)
    scores = {name: Scores(_runs(name, task, range(seed, seed + episodes))) for name in CONTENDERS}
    title = f"{counted(episodes, 'episode')} each, backend {backend}, seeds from {seed}"
    Console().print(scores_table(scores, title))
    if save is not None:
        _save(scores, title, save)
        typer.echo(f"saved {save}")


def scores_table(scores: Mapping[str, Scores], title: str) -> Table:
    """Return the table of what the agents come to, with 95% intervals."""
    table = Table(title=title, caption="all but success and expanded: of what was delivered")
    table.add_column("agent")
    for measure in MEASURES:
        table.add_column(measure.column, justify="right")
    for name, each in scores.items():
        cells = (measure.of(each) for measure in MEASURES)
        first, *others = cells
        assert first is not None, "a share there always is"
        words = [share(first), *("none" if cell is None else mean(cell, "") for cell in others)]
        # The interval below its estimate, so that the table fits a terminal.
        table.add_row(name, *(each.replace(" (", "\n(") for each in words))
    return table


def _runs(name: str, task: Task, seeds: range) -> list[Run]:
    console = Console(stderr=True)
    bar = track(seeds, name, console=console, transient=True, disable=not console.is_terminal)
    return [run_agent(CONTENDERS[name], task, seed) for seed in bar]


def _save(scores: Mapping[str, Scores], title: str, path: Path) -> None:
    from agents.evaluation.figure import scores_figure

    figure = scores_figure(scores, title)
    with atomic_path(path) as part:
        if path.suffix.lower() == ".svg":
            save_svg(figure, part)
        else:
            figure.pixels().save(part, format="PNG")
