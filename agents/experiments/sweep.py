"""Run every combination of some settings, and keep a row for each episode.

The same command again runs what is missing; a command with more episodes or further values adds
to what is there.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from agents.errors import ParameterError
from agents.evaluation.wording import counted
from agents.experiments.choices import PlanFile, parse_flags, read_plan_file
from agents.experiments.parameters import SETTINGS
from agents.experiments.plan import Plan, make_plan
from agents.experiments.presets import PRESETS
from agents.experiments.running import Report, run_missing
from agents.experiments.store import Row, Store
from agents.experiments.workers import Check, Hands, cluster, processes, remembered_interrupts
from warehouse_core.records.episode import DELIVERED


@contextmanager
def sweep_bar(episodes: int) -> Iterator[Report]:
    """Show a bar while the block runs, and yield the function that takes each stored row."""
    from agents.console.progress import progress_bar

    counts = {"all": 0, "delivered": 0}
    with progress_bar(episodes) as advance:

        def report(rows: Sequence[Row]) -> None:
            counts["all"] += len(rows)
            counts["delivered"] += sum(row.mode == DELIVERED for row in rows)
            if rows:
                share = counts["delivered"] / counts["all"]
                advance(counts["all"], f"{share:.0%} delivered")

        yield report


EPISODES = 100
"""Of each combination where nothing else is said."""


def sweep(
    file: Annotated[
        Path | None, typer.Argument(metavar="[PLAN]", help="A plan as .toml.", show_default=False)
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUES",
            help="Values, as in battery=20,60 or battery=20:200:20; may be given more than once. "
            f"Names: {', '.join(SETTINGS)}, robot.NUMBER, disturbances.NUMBER.",
        ),
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option("--preset", help=f"A question of the chapter: {', '.join(PRESETS)}."),
    ] = None,
    episodes: Annotated[
        int | None,
        typer.Option(
            "--episodes", "-n", min=1, help="Of each combination.", show_default=str(EPISODES)
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed",
            metavar="N",
            help="Of the first episode of each combination.",
            show_default="0",
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="Where the results go.")
    ] = Path("results.sqlite"),
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", min=1, max=1024, help="Processes.", show_default="one for each core"
        ),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option("--cluster", metavar="tcp://HOST:PORT", help="A Dask scheduler."),
    ] = None,
) -> None:
    """Run episodes under every combination of settings; the same again resumes."""
    given = _given(file, preset)
    choices = given.choices | parse_flags(settings or [])
    plan = make_plan(choices, episodes or given.episodes or EPISODES, _first(seed, given.seed))
    with remembered_interrupts() as check, Store(output) as store:
        store.add_cases(plan.cases)
        done = _done(plan, store)
        cases, each = counted(len(plan.cases), "combination"), counted(plan.episodes, "episode")
        typer.echo(f"{cases}, {each} each, {done:,} done")
        missing = plan.total - done
        hands = _hands(min(workers or os.cpu_count() or 1, missing), address)
        try:
            if missing:
                _run(plan, store, missing, hands, check)
        except KeyboardInterrupt:
            done = _done(plan, store)
            typer.echo(f"{done:,} of {plan.total:,} episodes in {output}; the same command goes on")
            raise typer.Abort from None  # typer would end without a word
    episodes_done = f"{counted(plan.total, 'episode')} done"
    typer.echo(f"{episodes_done}; see what they come to with: warehouse report {output}")


def _given(file: Path | None, preset: str | None) -> PlanFile:
    """Return the plan that flags are added to."""
    if file is not None and preset is not None:
        raise ParameterError(f"both {file} and --preset {preset} are given; one plan will do")
    if file is not None:
        return read_plan_file(file)
    if preset is None:
        return PlanFile({}, None, None)
    if preset not in PRESETS:
        raise ParameterError(f"no preset is called {preset!r}; allowed: {', '.join(PRESETS)}")
    return PlanFile(PRESETS[preset].choices, PRESETS[preset].episodes, None)


def _done(plan: Plan, store: Store) -> int:
    """Return how many episodes of a plan are there."""
    return sum(store.count(case, plan.seeds) for case in plan.cases)


def _hands(workers: int, address: str | None) -> Hands:
    return processes(workers) if address is None else cluster(address)


def _run(plan: Plan, store: Store, missing: int, hands: Hands, check: Check) -> None:
    with hands as (executor, count), sweep_bar(missing) as show:

        def report(rows: Sequence[Row]) -> None:
            show(rows)
            check()

        run_missing(plan, store, executor, count, report)


def _first(*seeds: int | None) -> int:
    return next((seed for seed in seeds if seed is not None), 0)
