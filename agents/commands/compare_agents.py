"""The command ``warehouse compare-agents``: agents over the same seeds, a table and a figure."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from agents.console.options import (
    BackendOption,
    BatteryOption,
    LayoutOption,
    MaxStepsOption,
    load_layout,
)
from agents.console.table import Table, print_table
from agents.evaluation.scores import MEASURES, MakeAgent, Scores, Task, evaluate
from agents.evaluation.wording import mean, share
from agents.search.agents import ExploringAgent, SearchAgent
from agents.warehouse_agent_greedy import GreedyAgent
from warehouse_core import Layout
from warehouse_core.files.atomic import atomic_path, check_suffix, check_target
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
    """Compare agents over the same seeds."""
    if save is not None:
        check_suffix(save, PICTURES)
        check_target(save)
    task, seeds = (
        Task(load_layout(layout), battery, max_steps, backend),
        range(seed, seed + episodes),
    )
    agents = contenders(task.layout)
    scores = {name: _evaluate(name, make, task, seeds) for name, make in agents.items()}
    title = f"{counted(episodes, 'episode')} each, backend {backend}, seeds from {seed}"
    print_table(scores_table(scores, title))
    if save is not None:
        _save(scores, title, save)
        typer.echo(f"saved {save}")


def contenders(layout: Layout) -> dict[str, MakeAgent]:
    """Return what makes each agent: the chapter's, and those that search instead."""
    return {
        "greedy": GreedyAgent,
        "greedy without escape": partial(GreedyAgent, escape_steps=0),
        "exploring": lambda _: ExploringAgent(),
        "uniform-cost": lambda _: SearchAgent(layout, "ucs"),
        "A*": lambda _: SearchAgent(layout, "astar"),
    }


def scores_table(scores: Mapping[str, Scores], title: str) -> Table:
    """Return the table of the agents' scores, with 95% intervals."""
    rows = []
    for name, each in scores.items():
        first, *others = (measure.of(each) for measure in MEASURES)
        assert first is not None, "there is always a share"
        words = [share(first), *("none" if cell is None else mean(cell, "") for cell in others)]
        # The interval below its estimate, so that the table fits a terminal.
        rows.append((name, *(each.replace(" (", "\n(") for each in words)))
    header = ("agent", *(measure.column for measure in MEASURES))
    return Table(header, rows, title, "all but success and expanded: of what was delivered")


def _evaluate(name: str, make_agent: MakeAgent, task: Task, seeds: range) -> Scores:
    from agents.console.progress import track

    return evaluate(make_agent, task, track(seeds, name))


def _save(scores: Mapping[str, Scores], title: str, path: Path) -> None:
    from agents.evaluation.figure import scores_figure
    from warehouse_core.viz.figure import save_svg

    figure = scores_figure(scores, title)
    with atomic_path(path) as part:
        if path.suffix.lower() == ".svg":
            save_svg(figure, part)
        else:
            figure.pixels().save(part, format="PNG")
