"""The command ``warehouse sweep``, which runs every combination of settings.

Each episode is stored as it finishes. When the same command is run again, it runs only the missing
episodes, so that more episodes or values can be added later.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from agents.errors import EpisodeError, ParameterError
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.terminal import print_error, say
from agents.lab.experiments.plan import (
    MAX_EPISODES,
    PlanFile,
    SweepPlan,
    make_plan,
    parse_flags,
    read_plan_file,
)
from agents.lab.experiments.running import ReportRows, run_missing
from agents.lab.experiments.store import Store
from agents.lab.parameters import MAX_SEED, PARAMETERS, PHYSICAL, Whole
from agents.lab.trials.rows import AnyRow
from agents.lab.trials.workers import CheckInterrupt, Processes, deferred_interrupts
from warehouse_core.wording import counted


@contextmanager
def sweep_bar(episodes: int, check: CheckInterrupt) -> Iterator[ReportRows]:
    """Show a progress bar, and yield a function that advances it and checks for interrupts.

    The function also prints each new message of a failure.
    """
    from agents.lab.console.progress import progress_bar

    done, reported = 0, set[str]()
    with progress_bar(episodes) as advance:

        def report(rows: Sequence[AnyRow], failures: Sequence[str]) -> None:
            nonlocal done
            for failure in {*failures} - reported:
                reported.add(failure)  # a failure of a whole case is repeated for each seed
                print_error(failure)
            if rows:
                done += len(rows)
                advance(done)
            check()

        yield report


PRESETS = {
    name: Path(__file__).parent / "presets" / f"{name}.toml"
    for name in ("escape", "battery", "obstacles", "size", "backends", "fleet")
}
"""Plan files for the chapter's questions and one for fleets.

Each takes less than a minute on two cores.
"""

EPISODES = 100
"""Default number of episodes per combination."""

NAMES = "\n".join(
    [
        "\b\nNames of --set:",
        *(f"  {name:<12}{each.values.format(each.check)}" for name, each in PARAMETERS.items()),
        f"  {' and '.join(f'{group}.NAME' for group in PHYSICAL)}, for physics",
    ]
)
"""Names of the parameters and descriptions of their values, as lines of the help."""


def sweep(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="PLAN",
            help="A .toml file with the keys episodes and seed and the tables settings, robot and "
            "disturbances.",
            show_default=False,
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        option(
            "--set NAME=VALUES",
            "Set a setting to a value (agent=astar), a list (battery=20,60) or a range "
            "(battery=20:200:20). May be repeated. The names are listed below.",
        ),
    ] = None,
    preset: Annotated[
        str | None,
        option(
            "--preset NAME",
            f"Run a prepared sweep for a question of the chapter: {', '.join(PRESETS)}.",
        ),
    ] = None,
    episodes: Annotated[
        int | None,
        option(
            "--episodes -n N",
            f"{options.EPISODES} Default: {EPISODES}.",
            Whole(1, MAX_EPISODES),
        ),
    ] = None,
    seed: Annotated[
        int | None,
        option(
            "--seed N",
            f"{options.SEED} Default: 0.",
            Whole(0, MAX_SEED),
        ),
    ] = None,
    output: Annotated[
        Path, option("--save -o FILE", f"{options.SAVE} Results that it already has are kept.")
    ] = Path("results.sqlite"),
    jobs: options.Jobs = None,
) -> None:
    """Run every combination of settings.

    Each episode is stored as it finishes. Run the same command again to resume, or run it with more
    episodes or values to add those. See the results with 'warehouse report'.

    Example: warehouse sweep --set agent=greedy,astar --set battery=20:200:20
    """
    given = _given(file, preset)
    choices = given.choices | parse_flags(settings or [])
    first = (given.seed or 0) if seed is None else seed
    plan = make_plan(choices, episodes or given.episodes or EPISODES, first)
    with deferred_interrupts() as check, Store(output) as store:
        store.add_cases(plan.cases)
        done = _done(plan, store)
        cases, each = counted(len(plan.cases), "combination"), counted(plan.episodes, "episode")
        say(f"{cases}, {each} each, {done:,} done")
        missing, failed = plan.total - done, Counter[int]()
        count = min(jobs or os.cpu_count() or 1, missing)
        try:
            if missing:
                with Processes(count) as pool, sweep_bar(missing, check) as report:
                    failed = run_missing(plan, store, pool, count, report)
        except KeyboardInterrupt:
            done = _done(plan, store)
            say(
                f"{output} now has {done:,} of {plan.total:,} episodes; run the same command again "
                "to resume"
            )
            raise typer.Abort from None  # typer would end without a message
        if failed:
            raise EpisodeError(
                f"{counted(failed.total(), 'episode')} failed (in {len(failed)} of {cases}); "
                f"{output} now has {_done(plan, store):,} of {plan.total:,} episodes; run the same "
                "command again to run the missing ones"
            )
    episodes_done = f"{counted(plan.total, 'episode')} done"
    say(f"{episodes_done}; see the results with: warehouse report {output}")


def _given(file: Path | None, preset: str | None) -> PlanFile:
    """Return the contents of the plan file or of the preset, or an empty plan without either."""
    if preset is not None:
        if file is not None:
            raise ParameterError(f"both {file} and --preset {preset} are given; give one of them")
        if preset not in PRESETS:
            raise ParameterError(f"no preset is called {preset!r}; allowed: {', '.join(PRESETS)}")
        file = PRESETS[preset]
    return PlanFile({}) if file is None else read_plan_file(file)


def _done(plan: SweepPlan, store: Store) -> int:
    """Return the number of stored episodes of a plan."""
    return sum(store.count(case, plan.seeds) for case in plan.cases)
