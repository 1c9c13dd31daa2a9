"""Comparison of an episode on two backends, for ``warehouse compare backends``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import typer

from agents.lab.commands.run import run_episode
from agents.lab.console.output import Film, show_or_save
from agents.lab.console.table import TextTable, print_table
from agents.lab.console.values import load_place, with_slippery
from agents.lab.place import Stations
from agents.lab.runs.run import draw_seed
from warehouse_core import Episode
from warehouse_core.viz.tracks.record_track import track_of_record
from warehouse_core.wording import seconds_of

BACKENDS = "grid", "physics"

ROWS: dict[str, Callable[[Episode], str]] = {
    "outcome": lambda episode: episode.outcome,
    "steps": lambda episode: str(episode.steps),
    "total reward": lambda episode: f"{episode.total_reward:.2f}",
    "seconds": lambda episode: seconds_of(episode.seconds),
    "joules": lambda episode: f"{episode.joules:.0f}",
    "hits": lambda episode: str(sum(len(motion.contacts) for motion in episode.motions)),
}


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


def comparison_table(left: Episode, right: Episode) -> TextTable:
    """Return a table that compares the results of two episodes."""
    step = first_difference(left, right)
    differs = "none" if step is None else f"step {step}"
    rows = [(name, value(left), value(right)) for name, value in ROWS.items()]
    return TextTable(
        ("", left.settings.backend, right.settings.backend),
        [*rows, ("first step that differs", differs, differs)],
        f"{left.agent}, seed {left.seed}",
    )


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
    """Run an episode on two backends and show both replays side by side.

    The default is ``BACKENDS``. A single backend is compared with the first of them.
    """
    backends = [*BACKENDS[: 2 - len(backend)], *backend]
    if len(backends) != 2:
        raise typer.BadParameter(f"--backend is given {len(backend)} times; two are compared")
    seed = draw_seed() if seed is None else seed
    place = load_place(layout, stations, start)
    backends = with_slippery(slippery, place.layout, *backends)
    one, other = (
        run_episode(
            agent, backend, seed=seed, battery=battery, max_steps=max_steps, **place._asdict()
        )
        for backend in backends
    )
    print_table(comparison_table(one, other))
    film = Film(lambda: [track_of_record(one), track_of_record(other)])
    names = (episode.settings.backend for episode in (one, other))
    show_or_save(film, save, show, f"compare-{one.agent}-{'-'.join(names)}-{seed}.gif")
