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
        done: number of episodes of the plan that were stored before the run.
        failed: number of failures of each case, by its number.
    """

    def __init__(self, plan: SweepPlan, store: Store) -> None:
        self.failed, self._task_episodes, self._store = Counter[int](), 1, store
        cases = zip(store.case_ids(plan.cases), plan.cases, strict=True)
        self._cases, self._seeds = dict(cases), plan.seeds
        self.done = self.count()
        self._missing, self._again = self._missing_tasks(), list[WorkerTask]()

    def count(self) -> int:
        """Return the number of stored episodes of the plan."""
        return sum(self._store.count(each, self._seeds) for each in self._cases)

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
            finished, _ = wait(running, TICK, return_when=FIRST_COMPLETED)
            yield [], ""
            for future in finished:
                yield self._finish(running.pop(future), future)

    def _missing_tasks(self) -> Iterator[WorkerTask]:
        """Yield the missing episodes in tasks of the current size."""
        for case_id, case in self._cases.items():
            done = self._store.seeds_done(case_id, self._seeds)
            seeds = (seed for seed in self._seeds if seed not in done)
            while some := list(islice(seeds, self._task_episodes)):
                yield WorkerTask(case_id, case, some)

    def _take(self) -> WorkerTask | None:
        """Return the next task of a case that is still wanted, or ``None`` if no task is left."""
        while task := self._again.pop() if self._again else next(self._missing, None):
            if self.failed[task.case_id] < MAX_FAILURES:
                return task
        return None

    def _finish(self, task: WorkerTask, future: Future[Done]) -> tuple[list[AnyRow], str]:
        """Store the rows of a task, and return them and its failure, if it is one."""
        try:
            done = future.result()
        except WorkerError as ending:
            if not task.is_retry:
                self._again += [task._replace(seeds=[seed], is_retry=True) for seed in task.seeds]
                return [], ""
            done = Done(0.0, [], "", f"{about(task.case, task.seeds[0])}: {ending}, twice")
        self._store.add(task.case_id, done.rows, done.program)
        if done.failure is None:
            self._task_episodes = paced(len(task.seeds), done.seconds)
            return done.rows, ""
        if rest := task.seeds[len(done.rows) + 1 :]:
            self._again.append(task._replace(seeds=rest))
        self.failed[task.case_id] += 1
        if self.failed[task.case_id] < MAX_FAILURES:
            return done.rows, done.failure
        skipped = f"its other seeds are skipped after MAX_FAILURES = {MAX_FAILURES}"
        return done.rows, f"{done.failure}; {skipped}"


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
        run = SweepRun(plan, store)
        cases, each = counted(len(plan.cases), "combination"), counted(plan.episodes, "episode")
        say(f"{cases}, {each} each, {run.done:,} done")
        missing = plan.total - run.done
        workers = min(jobs or os.cpu_count() or 1, missing)
        try:
            if missing:
                with Processes(workers) as pool:
                    show_progress(run.episodes(pool, workers), missing, check)
        except KeyboardInterrupt:
            say(f"{_now(output, run, plan)}; run the same command again to resume")
            raise typer.Abort from None  # typer would end without a message
        if run.failed:
            failed = f"{counted(run.failed.total(), 'episode')} failed"
            raise EpisodeError(
                f"{failed} (in {len(run.failed)} of {cases}); {_now(output, run, plan)}; run the "
                "same command again to run the missing ones"
            )
    say(f"{counted(plan.total, 'episode')} done; see the results with: warehouse report {output}")


def _now(output: Path, run: SweepRun, plan: SweepPlan) -> str:
    return f"{output} now has {run.count():,} of {plan.total:,} episodes"


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
