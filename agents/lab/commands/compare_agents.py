"""Comparison of agents over the same seeds, for ``warehouse compare agents``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

import typer

from agents.errors import EpisodeInterrupted
from agents.lab.commands import random_layouts
from agents.lab.console.output import save_picture
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.console.watch import slow_steps_reported
from agents.lab.place import Stations, what_to_draw
from agents.lab.trials.interval import mean, share
from agents.lab.trials.scores import EXPLANATION, GRID_MEASURES, MEASURES, Measure, Scores
from agents.lab.trials.task import Task, load_task
from agents.registry import make_agent
from warehouse_core import Agent, Layout
from warehouse_core.wording import counted

AGENTS = {
    "random": "random",
    "reflex": "reflex",
    "greedy": "greedy",
    "greedy:escape_steps=0": "greedy without escape",
    "exploring": "exploring",
    "ucs": "uniform-cost",
    "astar": "A*",
}
"""Agents that are compared by default, and their names in the table."""


def compare_agents(
    agent: Sequence[str] = (),
    episodes: int = 100,
    seed: int = 0,
    backend: str = "grid",
    layout: Path | None = None,
    stations: Stations | None = None,
    start: str | None = None,
    battery: int = 200,
    max_steps: int = 200,
    size: list[str] | None = None,
    density: str | None = None,
    save: Sequence[Path] = (),
) -> None:
    """Compare agents over the same seeds, by default ``AGENTS``.

    Prints tables of deliveries, steps, expanded nodes, time and energy, and saves them as a figure.
    Several sizes of random layouts share one figure.
    """
    if len(save) > 1:
        raise typer.BadParameter(
            f"'compare agents' saves one figure; --save is given {len(save)} times"
        )
    tasks = make_tasks(layout, size, density, stations, start)
    tasks = [task._replace(battery=battery, max_steps=max_steps, backend=backend) for task in tasks]
    names = {name: AGENTS.get(name, name) for name in agent or AGENTS}
    seeds = range(seed, seed + episodes)
    for name in names:  # so that a wrong name is an error before any episode runs
        make_agent(name, seeds[-1], tasks[0].layout_for(seeds[-1]))
    groups = {
        title_of(task, seeds): {
            shown: evaluate_watched(name, shown, task, seeds) for name, shown in names.items()
        }
        for task in tasks
    }
    measures = GRID_MEASURES if backend == "grid" else MEASURES
    # The figure first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        from agents.lab.trials.figure import scores_figure

        save_picture(scores_figure(groups, measures, EXPLANATION), path)
    for title, scores in groups.items():
        for table in scores_tables(scores, title, measures):
            print_table(table)
    say(fill(EXPLANATION, get_terminal_size().columns))
    for path in save:
        say(f"saved {path}")


def make_tasks(
    layout: Path | None,
    sizes: list[str] | None,
    density: str | None,
    stations: Stations | None,
    start: str | None,
) -> list[Task]:
    """Return a task for each size of random layouts, or one task for another layout."""
    if not random_layouts.are_wanted(layout, size=sizes, density=density):
        return [load_task(layout, stations, start)]
    if start is not None:
        raise typer.BadParameter(
            "--start cannot be combined with --layout random, where starts are random"
        )
    randomize = what_to_draw(stations or Stations.DRAWN)
    wanted: Sequence[str | None] = sizes or [None]
    return [Task(random_layouts.parse(size, density), randomize=randomize) for size in wanted]


def title_of(task: Task, seeds: range) -> str:
    """Return a title with the settings that the episodes of a task share."""
    layouts = "" if isinstance(task.layout, Layout) else f"{task.layout.name}, "
    return (
        f"{layouts}{counted(len(seeds), 'episode')} each, backend {task.backend}, "
        f"seeds from {seeds.start}, {task.stations.words}"
    )


def evaluate_watched(name: str, shown: str, task: Task, seeds: Sequence[int]) -> Scores:
    """Run the episodes of an agent, show a progress bar, and return the scores."""
    from agents.lab.console.progress import track

    def make(seed: int) -> Agent:
        return make_agent(name, seed, task.layout_for(seed))

    try:
        return task.evaluate(make, track(seeds, shown), name, slow_steps_reported)
    except EpisodeInterrupted as error:
        raise typer.Abort from error


def scores_tables(
    scores: Mapping[str, Scores], title: str, measures: Sequence[Measure]
) -> Iterator[TextTable]:
    """Yield two tables of the agents' scores with 95% intervals; each fits into 80 columns."""
    half = len(measures) // 2
    for part, above in ((measures[:half], title), (measures[half:], "")):
        rows = [(name, *(_words(each, one) for one in part)) for name, each in scores.items()]
        yield TextTable(("agent", *(measure.column for measure in part)), rows, above)


def _words(scores: Scores, measure: Measure) -> str:
    found = measure.of(scores)
    if found is None:
        return "none"
    words = share(found) if measure is MEASURES[0] else mean(found, "")
    return words.replace(" (", "\n(")  # the interval below its estimate, to save width
