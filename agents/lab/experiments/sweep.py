"""The command ``warehouse sweep``, which runs every combination of settings.

Each episode is stored as it finishes. When the same command is run again, it runs only the missing
episodes, so that more episodes or values can be added later.

Workers receive episodes in tasks of about half a second. Tasks of this length are long enough that
the cost of sending them is negligible, and short enough that an error loses little and the progress
bar keeps moving. The rows of a task depend only on its case and seeds, so they do not depend on the
number of workers.

An episode that fails is reported, and the others continue. When a worker process ends, any seed of
its task may be the cause. Therefore each seed is run again as a separate task, and a seed whose
worker ends a second time has failed.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from agents.errors import EpisodeError, ParameterError, WorkerError
from agents.lab.console import options
from agents.lab.console.options import option
from agents.lab.console.terminal import print_error, say
from agents.lab.experiments.case import Case, Done, about, run_task
from agents.lab.experiments.plan import (
    MAX_EPISODES,
    PlanFile,
    SweepPlan,
    make_plan,
    parse_flags,
    read_plan_file,
)
from agents.lab.experiments.store import Store
from agents.lab.parameters import MAX_SEED, PARAMETERS, PHYSICAL, Whole
from agents.lab.trials.rows import AnyRow
from agents.lab.trials.workers import CheckInterrupt, Processes, deferred_interrupts
from warehouse_core.wording import counted

TASK_SECONDS, MAX_TASK_EPISODES = 0.5, 10_000

SEEDS_AT_ONCE = 100_000
"""Number of seeds that are looked up in the store at once."""

TASKS_PER_WORKER = 2
"""Number of submitted tasks per worker, so that no worker has to wait for its next task."""

TICK = 0.1
"""Seconds after which a run yields even if no task has finished."""

MAX_FAILURES = 20
"""Number of failed episodes of a case after which its remaining seeds are skipped."""


class WorkerTask(NamedTuple):
    """Seeds of a case for one worker; ``is_retry`` if an earlier worker ended while running it."""

    case_id: int
    case: Case
    seeds: list[int]
    is_retry: bool = False


def paced(episodes: int, seconds: float) -> int:
    """Return the number of episodes of the next tasks, given the duration of a finished task."""
    wanted = episodes * TASK_SECONDS / max(seconds, 1e-6)
    # At most four times as many, because one short episode says little about the others.
    return max(1, min(round(wanted), 4 * episodes, MAX_TASK_EPISODES))


class SweepRun:
    """The run of the missing episodes of a plan.

    Attributes:
        failed: number of failures of each case, by its number.
    """

    def __init__(self, plan: SweepPlan, store: Store) -> None:
        self.failed, self._task_episodes, self._store = Counter[int](), 1, store
        self._missing, self._again = self._missing_tasks(plan), list[WorkerTask]()

    def episodes(self, executor: Executor, workers: int) -> Iterator[tuple[list[AnyRow], str]]:
        """Run the episodes, and yield new rows in the store and the message of a failure, if any.

        Without news, it yields nothing of either, see ``TICK``. An error of the store or the
        executor ends the run. Rows that have been written remain in the store.
        """
        running = dict[Future[Done], WorkerTask]()
        while True:
            while len(running) < TASKS_PER_WORKER * workers and (task := self._take()):
                running[executor.submit(run_task, task.case, task.seeds)] = task
            if not running:
                return
            done, _ = wait(running, TICK, return_when=FIRST_COMPLETED)
            yield [], ""
            # Tasks without an outcome come last, because they may end the run.
            for future in sorted(done, key=lambda each: each.cancelled() or bool(each.exception())):
                task = running.pop(future)
                try:
                    outcome = future.result()
                except WorkerError as ending:
                    yield [], self._ended(task, str(ending))
                else:
                    self._store.add(task.case_id, outcome.rows, outcome.program)
                    yield outcome.rows, self._done(task, outcome)

    def _take(self) -> WorkerTask | None:
        """Return the next task, or ``None`` if no task is left."""
        while self._again:
            if self._is_wanted(task := self._again.pop()):
                return task
        return next(self._missing, None)

    def _done(self, task: WorkerTask, outcome: Done) -> str:
        """Record that a task has finished, and return the failure, if it is one."""
        if outcome.failure is None:
            self._task_episodes = paced(len(task.seeds), outcome.seconds)
            return ""
        if rest := task.seeds[len(outcome.rows) + 1 :]:
            self._again.append(task._replace(seeds=rest))
        return self._failed(task, outcome.failure)

    def _ended(self, task: WorkerTask, ending: str) -> str:
        """Record that the worker of a task has ended, and return the failure, if it is one."""
        if not task.is_retry:
            self._again += [task._replace(seeds=[seed], is_retry=True) for seed in task.seeds]
            return ""
        return self._failed(
            task, f"{about(task.case, task.seeds[0])}: {ending}; it was tried twice"
        )

    def _failed(self, task: WorkerTask, message: str) -> str:
        self.failed[task.case_id] += 1
        if not self._is_wanted(task):
            message += f"; its other seeds are skipped after MAX_FAILURES = {MAX_FAILURES}"
        return message

    def _missing_tasks(self, plan: SweepPlan) -> Iterator[WorkerTask]:
        """Yield the missing episodes in tasks of the current size, skipping cases that fail."""
        for case in plan.cases:
            case_id = self._store.case_id(case)
            seeds = _missing_seeds(self._store, case_id, plan.seeds)
            while self.failed[case_id] < MAX_FAILURES:
                if not (some := list(islice(seeds, self._task_episodes))):
                    break
                yield WorkerTask(case_id, case, some)

    def _is_wanted(self, task: WorkerTask) -> bool:
        return self.failed[task.case_id] < MAX_FAILURES


def _missing_seeds(store: Store, case_id: int, seeds: range) -> Iterator[int]:
    """Yield the seeds that are not in the store, looking them up in parts to save memory."""
    for start in range(0, len(seeds), SEEDS_AT_ONCE):
        some = seeds[start : start + SEEDS_AT_ONCE]
        done = store.seeds_done(case_id, some)
        yield from (seed for seed in some if seed not in done)


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
        missing, run = plan.total - done, SweepRun(plan, store)
        count = min(jobs or os.cpu_count() or 1, missing)
        try:
            if missing:
                with Processes(count) as pool:
                    show_progress(run.episodes(pool, count), missing, check)
        except KeyboardInterrupt:
            done = _done(plan, store)
            say(
                f"{output} now has {done:,} of {plan.total:,} episodes; run the same command again "
                "to resume"
            )
            raise typer.Abort from None  # typer would end without a message
        if run.failed:
            failed = f"{counted(run.failed.total(), 'episode')} failed"
            raise EpisodeError(
                f"{failed} (in {len(run.failed)} of {cases}); "
                f"{output} now has {_done(plan, store):,} of {plan.total:,} episodes; run the same "
                "command again to run the missing ones"
            )
    episodes_done = f"{counted(plan.total, 'episode')} done"
    say(f"{episodes_done}; see the results with: warehouse report {output}")


def show_progress(
    news: Iterator[tuple[list[AnyRow], str]], total: int, check: CheckInterrupt
) -> None:
    """Show the progress of a run, print each failure once, and check for interrupts."""
    from agents.lab.console.progress import progress_bar  # here, because it loads Rich

    done, reported = 0, {""}  # "" is no failure
    with progress_bar(total) as advance:
        for rows, failure in news:
            if failure not in reported:  # a failure of a whole case is repeated for each seed
                print_error(failure)
                reported.add(failure)
            if rows:
                done += len(rows)
                advance(done)
            check()


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
