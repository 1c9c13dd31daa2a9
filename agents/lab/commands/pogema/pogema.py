"""The command ``warehouse pogema``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated

import typer

from agents.lab.commands.planners.mapf import PLANNER
from agents.lab.commands.planners.runs import SOLVERS, is_solver, is_stepper, make_stepper
from agents.lab.commands.pogema.benchmark import SETS, SITE, Instance, Kind, instances
from agents.lab.commands.pogema.results import Results, key_of, program_of
from agents.lab.commands.pogema.summary import groups_of, late_steps, tables
from agents.lab.commands.pogema.trial import Outcome, run_instance
from agents.lab.console import options
from agents.lab.console.options import MANY, one_of, option, writable
from agents.lab.console.table import print_table
from agents.lab.console.terminal import print_error, say
from agents.lab.console.values import parse_sizes
from agents.lab.experiments.cluster import cluster
from agents.lab.experiments.running import TASKS_PER_WORKER, TICK
from agents.lab.trials.workers import Here, deferred_interrupts, process_pool
from warehouse_core import DEFAULT_LAYOUT
from warehouse_core.wording import counted, listed

DEFAULTS = {Kind.ONE_SHOT: ["anytime"], Kind.LIFELONG: ["windowed"]}
"""Planners of each kind of episodes, if none is named."""

VALUES, PAGE = ".csv", ".html"

Task = tuple[Instance, str]
"""An episode and the name of its planner."""


def pogema(
    sets: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SET",
            help=f"Sets of maps: {', '.join(SETS)}. Default: all.",
            show_default=False,
        ),
    ] = None,
    planner: Annotated[
        list[str] | None,
        option(
            "--planner NAME",
            f"{PLANNER} Solvers of whole problems ({', '.join(SOLVERS)}, or file.py:function) run "
            "one-shot episodes, planners of steps lifelong ones. Default: anytime and windowed.",
            show_default=False,
        ),
    ] = None,
    kind: Annotated[
        Kind | None,
        option(f"--kind {'|'.join(Kind)}", "Episodes of this kind alone.", one_of(Kind)),
    ] = None,
    robots: Annotated[
        str | None,
        option(
            "--robots -r N,N",
            f"{options.ROBOTS} Several, separated by commas. Default: all.",
            show_default=False,
        ),
    ] = None,
    episodes: options.Episodes = 20,
    data: Annotated[
        Path | None,
        option(
            "--data FOLDER",
            f"Copy of {SITE}, for the maps of movingai and puzzles; the other sets need none.",
        ),
    ] = None,
    plan_seconds: options.PlanSeconds = 2.0,
    jobs: options.Jobs = None,
    address: options.Cluster = None,
    *,
    save: Annotated[
        list[Path],
        option(
            "--save -o FILE",
            f"{options.SAVE} Each episode as .csv, whose results are kept; a page with curves and "
            "tables as .html; may be repeated.",
            callback=writable(VALUES, PAGE),
            **MANY,
        ),
    ],
) -> None:
    """Compare planners with POGEMA's results.

    Maps, starts and goals equal the published ones. Run the same command with the
    same .csv again to resume, or with more episodes or planners to add those.

    All sets take an hour or two of processor time by default. Name sets, numbers
    of robots or fewer episodes for less.

    Example: warehouse pogema mazes --planner lacam -r 64 --save mazes.csv
    """
    tasks = plan(sets, planner, kind, robots, episodes, data)
    results = Results(next((path for path in save if path.suffix == VALUES), None))
    for name in dict.fromkeys(name for _, name in tasks):
        results.check_program(name)
    missing = [task for task in tasks if key_of(*task, plan_seconds) not in results.outcomes]
    say(f"{counted(len(tasks), 'episode')}, {len(tasks) - len(missing):,} done")
    run_all(missing, plan_seconds, results, jobs, address)
    wanted = [key_of(*task, plan_seconds) for task in tasks]
    groups = groups_of({key: results.outcomes[key] for key in wanted})
    # The page first, because the reader of standard output may leave, as ``head`` does.
    for path in save:
        if path.suffix == PAGE:
            from agents.lab.commands.pogema.page import write_pogema_page  # imports matplotlib

            programs = dict.fromkeys(program_of(name) for _, name in tasks)
            write_pogema_page(
                path,
                groups,
                [
                    ("episodes", f"{episodes:,} for each number of robots, or all there are"),
                    ("seconds for a plan or a step", f"{plan_seconds:g}"),
                    ("program", listed(programs)),
                ],
            )
    for table in tables(groups):
        print_table(table)
    for warning in late_steps(groups):
        print_error(warning)
    for path in save:
        say(f"saved {path}")


def plan(
    sets: Sequence[str] | None,
    planners: Sequence[str] | None,
    kind: Kind | None,
    robots: str | None,
    episodes: int,
    data: Path | None,
) -> list[Task]:
    """Return the episodes to be run, each with its planner, or raise for what cannot be run."""
    names = list(dict.fromkeys(sets or SETS))
    if unknown := [name for name in names if name not in SETS]:
        raise typer.BadParameter(f"no set is called {unknown[0]!r}; allowed: {', '.join(SETS)}")
    by_kind = {
        each: planners_of(planners, each) if planners else DEFAULTS[each]
        for each in Kind
        if kind in (None, each)
    }
    if not any(by_kind.values()):
        raise typer.BadParameter(f"no planner of --planner runs episodes that are {kind}")
    if data is None and not sets:
        left_out = [name for name in names if SETS[name].draw is None]
        names = [name for name in names if name not in left_out]
        print_error(f"{listed(left_out)} are left out: their maps are in {SITE}; see --data")
    sizes = parse_sizes(robots) if robots else []
    known = sorted({size for name in names for size in SETS[name].sizes})
    if wrong := [size for size in sizes if size not in known]:
        raise typer.BadParameter(
            f"--robots has {wrong[0]}; allowed: {', '.join(map(str, known))}, as in the benchmark"
        )
    return [
        (instance, name)
        for each, chosen in by_kind.items()
        for instance in instances(names, [each] if chosen else [], sizes, episodes, data)
        for name in chosen
    ]


def planners_of(planners: Sequence[str], kind: Kind) -> list[str]:
    """Return the planners among some that run episodes of a kind; a wrong name is an error."""
    fits = is_solver if kind is Kind.ONE_SHOT else is_stepper
    found = [name for name in dict.fromkeys(planners) if fits(name)]
    for name in found if kind is Kind.LIFELONG else ():
        make_stepper(name, 0, DEFAULT_LAYOUT, 1, 1.0)
    return found


def run_all(
    tasks: Sequence[Task], seconds: float, results: Results, jobs: int | None, address: str | None
) -> None:
    """Run episodes on this machine or a cluster, and add their results as they finish."""
    from agents.lab.console.progress import progress_bar  # imports rich

    if not tasks:
        return
    count = min(jobs or os.cpu_count() or 1, len(tasks))
    pool: AbstractContextManager[tuple[Executor, int]] = nullcontext((Here(), 1))
    if address is not None:
        pool = cluster(address)
    elif count > 1:
        pool = process_pool(count)
    done, waiting = 0, iter(tasks)
    with (
        deferred_interrupts() as check,
        pool as (executor, workers),
        progress_bar(len(tasks)) as advance,
    ):
        running = dict[Future[Outcome], Task]()
        try:
            while True:
                while len(running) < TASKS_PER_WORKER * workers and (task := next(waiting, None)):
                    running[executor.submit(run_instance, *task, seconds)] = task
                if not running:
                    return
                ended, _ = wait(running, TICK, return_when=FIRST_COMPLETED)
                for future in [each for each in running if each in ended]:
                    results.add(*running.pop(future), seconds, future.result())
                    done += 1
                    advance(done)
                check()
        except KeyboardInterrupt:
            if results.path is not None:
                say(
                    f"{done:,} of {counted(len(tasks), 'episode')} more in {results.path}; run the "
                    "same command again to resume"
                )
            raise typer.Abort from None
