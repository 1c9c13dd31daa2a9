"""Comparison of an episode on several backends, for ``warehouse compare backends``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

import typer

from agents.code_names import split_name
from agents.lab.commands.worlds import NO_VALUE, on_one_clock, result_rows, story_of_worlds
from agents.lab.console.output import Film, show_or_save
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.terminal import say
from agents.lab.console.values import with_slippery
from agents.lab.place import Stations
from agents.lab.runs.run import draw_seed
from agents.lab.trials.task import load_task
from warehouse_core import Episode
from warehouse_core.viz.tracks.record_track import track_of_record

BACKENDS = "grid", "physics", "driving"


def first_difference(left: Episode, right: Episode) -> int | None:
    """Return the number, from 1, of the first step whose action, cell, load or reward differs.

    Time, energy and contacts are not compared. Return ``None`` if no step differs.
    """
    steps = [
        list(zip(e.actions, e.cells[1:], e.loaded[1:], e.rewards[1:], strict=True))
        for e in (left, right)
    ]
    for number, (one, other) in enumerate(zip(*steps, strict=False), start=1):
        if one != other:
            return number
    return None if left.steps == right.steps else min(left.steps, right.steps) + 1


def comparison_table(records: Mapping[str, Episode]) -> TextTable:
    """Return a table that compares the results of an agent on several backends."""
    first, *others = episodes = [*records.values()]
    steps = [first_difference(first, other) for other in others]
    differs = (NO_VALUE, *("none" if step is None else f"step {step}" for step in steps))
    rows = [*result_rows(episodes), ("first step that differs", *differs)]
    return TextTable(("", *records), rows, f"{first.agent}, seed {first.seed}")


def compare_backends(
    agent: str = "greedy",
    backend: Sequence[str] = (),
    layout: Path | None = None,
    stations: Stations | None = None,
    start: str | None = None,
    seed: int | None = None,
    battery: int = 200,
    max_steps: int = 200,
    slippery: Sequence[str] = (),
    save: Sequence[Path] = (),
    show: bool | None = None,
) -> None:
    """Run an episode on several backends and show the replays side by side.

    The default is ``BACKENDS``. A single backend is compared with the first of them.
    """
    backends = [*(BACKENDS if not backend else BACKENDS[: 2 - len(backend)]), *backend]
    if len({*backends}) < len(backends):
        raise typer.BadParameter(f"--backend names {backends[-1]} twice; it is compared once")
    seed = draw_seed() if seed is None else seed
    task = load_task(layout, stations, start, battery=battery, max_steps=max_steps)
    records = {
        backend: task._replace(backend=backend).run(agent, seed)
        for backend in with_slippery(slippery, layout, *backends)
    }
    print_table(comparison_table(records))
    say(fill(story_of_worlds(records), get_terminal_size().columns))
    film = Film(lambda: on_one_clock(records, [track_of_record(each) for each in records.values()]))
    names = "-".join(Path(split_name(backend).source).stem for backend in backends)
    agent = next(iter(records.values())).agent
    show_or_save(film, save, show, f"compare-{agent}-{names}-{seed}.gif")
