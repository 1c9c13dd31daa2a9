"""Run the episodes of a plan that are missing, and store them as they finish.

Workers get episodes in tasks of about half a second: long enough that the cost of sending them
is negligible, short enough that little is lost after an error and the progress bar moves. The rows
of a task depend only on its case and seeds, so they are the same with any number of workers.

An episode that fails is reported, and the others go on. If a worker ends, any seed of its task may
be the reason: each is run again as a task of its own, and one whose worker ends again has failed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from typing import NamedTuple

from agents.errors import WorkerError
from agents.lab.experiments.case import Case, Done, about, run_task
from agents.lab.experiments.plan import SweepPlan
from agents.lab.experiments.store import Store
from agents.lab.trials.rows import AnyRow

__all__ = ["run_missing"]

TASK_SECONDS, MAX_TASK_EPISODES = 0.5, 10_000

SEEDS_AT_ONCE = 100_000
"""Seeds that are looked up in the store at once."""

TASKS_PER_WORKER = 2
"""Tasks that are submitted for each worker, so that none has to wait for its next."""

TICK = 0.1
"""Seconds after which ``report`` is called even if no task is done."""

MAX_FAILURES = 20
"""Episodes of a case that fail before its other seeds are left out."""

TellRows = Callable[[Sequence[AnyRow], Sequence[str]], None]
"""Takes rows after they are stored, and messages of failures, often neither; may end the run."""


class WorkerTask(NamedTuple):
    """Seeds of a case; ``is_retry`` if the worker has ended that ran them before."""

    case_id: int
    case: Case
    seeds: list[int]
    is_retry: bool = False


def paced(episodes: int, seconds: float) -> int:
    """Return how many episodes make the next tasks, after some took so many seconds."""
    wanted = episodes * TASK_SECONDS / max(seconds, 1e-6)
    # At most four times as many: one short episode proves little.
    return max(1, min(round(wanted), 4 * episodes, MAX_TASK_EPISODES))


class Queue:
    """The tasks of a plan that are to be run, and the number of failures of each case."""

    def __init__(self, plan: SweepPlan, store: Store) -> None:
        self.failed, self._task_episodes = Counter[int](), 1
        self._missing, self._again = self._missing_tasks(plan, store), list[WorkerTask]()

    def take(self) -> WorkerTask | None:
        """Return the next task, if there is one."""
        while self._again:
            if self._is_wanted(task := self._again.pop()):
                return task
        return next(self._missing, None)

    def done(self, task: WorkerTask, outcome: Done) -> list[str]:
        """Take account of a task that is done, and return the messages of failures."""
        if outcome.failure is None:
            self._task_episodes = paced(len(task.seeds), outcome.seconds)
            return []
        if rest := task.seeds[len(outcome.rows) + 1 :]:
            self._again.append(task._replace(seeds=rest))
        return self._failed(task, outcome.failure)

    def ended(self, task: WorkerTask, ending: str) -> list[str]:
        """Take account of a task whose worker has ended, and return the messages of failures."""
        if not task.is_retry:
            self._again += [task._replace(seeds=[seed], is_retry=True) for seed in task.seeds]
            return []
        return self._failed(
            task, f"{about(task.case, task.seeds[0])}: {ending}; it was tried twice"
        )

    def _failed(self, task: WorkerTask, message: str) -> list[str]:
        self.failed[task.case_id] += 1
        if not self._is_wanted(task):
            message += f"; its other seeds are left out after MAX_FAILURES = {MAX_FAILURES}"
        return [message]

    def _missing_tasks(self, plan: SweepPlan, store: Store) -> Iterator[WorkerTask]:
        """Yield what is missing in tasks of the present size, while few have failed."""
        for case in plan.cases:
            case_id = store.case_id(case)
            seeds = _missing_seeds(store, case_id, plan.seeds)
            while self.failed[case_id] < MAX_FAILURES:
                if not (some := list(islice(seeds, self._task_episodes))):
                    break
                yield WorkerTask(case_id, case, some)

    def _is_wanted(self, task: WorkerTask) -> bool:
        return self.failed[task.case_id] < MAX_FAILURES


def run_missing(
    plan: SweepPlan, store: Store, executor: Executor, workers: int, report: TellRows
) -> Counter[int]:
    """Run what is not in the store, and return how many episodes of each case have failed.

    An error of the store, the executor or ``report`` ends the run; the rows written before stay.

    Example:
        >>> from concurrent.futures import ThreadPoolExecutor
        >>> from agents.lab.experiments.plan import make_plan
        >>> from agents.lab.experiments.running import run_missing
        >>> from agents.lab.experiments.store import Store
        >>> plan = make_plan({"memory": [5, 10]}, episodes=3, seed=7)
        >>> with Store("results.sqlite") as store, ThreadPoolExecutor(1) as executor:
        ...     failures = run_missing(plan, store, executor, 1, lambda rows, messages: None)
        ...     store.count(plan.cases[0], plan.seeds)
        3
    """
    queue, running = Queue(plan, store), dict[Future[Done], WorkerTask]()
    while True:
        while len(running) < TASKS_PER_WORKER * workers and (task := queue.take()):
            running[executor.submit(run_task, task.case, task.seeds)] = task
        if not running:
            return queue.failed
        done, _ = wait(running, TICK, return_when=FIRST_COMPLETED)
        report([], [])
        # Those without an outcome come last, because they may end the run.
        for future in sorted(done, key=lambda each: each.cancelled() or bool(each.exception())):
            task = running.pop(future)
            try:
                outcome = future.result()
            except WorkerError as ending:
                report([], queue.ended(task, str(ending)))
            else:
                store.add(task.case_id, outcome.rows, outcome.program)
                report(outcome.rows, queue.done(task, outcome))


def _missing_seeds(store: Store, case_id: int, seeds: range) -> Iterator[int]:
    """Yield the seeds that are not in the store, looked up in parts to save memory."""
    for start in range(0, len(seeds), SEEDS_AT_ONCE):
        some = seeds[start : start + SEEDS_AT_ONCE]
        done = store.seeds_done(case_id, some)
        yield from (seed for seed in some if seed not in done)
