"""Run the episodes of a plan that are missing, and store them as they finish.

Workers get episodes in tasks of about half a second: long enough that the cost of sending them
is negligible, short enough that little is lost after an error and the progress bar moves. The rows
of a task depend only on its case and seeds, so they are the same with any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice

from agents.errors import EpisodeError
from agents.experiments.case import Case
from agents.experiments.episodes import Done, run_task
from agents.experiments.plan import Plan
from agents.experiments.store import Row, Store

TASK_SECONDS = 0.5
MAX_TASK_EPISODES = 10_000

SEEDS_AT_ONCE = 100_000
"""Seeds that are looked up in the store at once."""

TASKS_PER_WORKER = 2
"""Tasks that are submitted for each worker, so that none has to wait for its next."""

TICK = 0.1
"""Seconds after which ``report`` is called even if no task is done."""

Report = Callable[[Sequence[Row]], None]
"""Called with rows after they are stored, and with none in between; what it raises ends the run."""


class Pace:
    """How many episodes make a task, learnt from those that have been run."""

    def __init__(self) -> None:
        self.episodes = 1

    def learn(self, episodes: int, seconds: float) -> None:
        """Take account of a task that is done."""
        wanted = episodes * TASK_SECONDS / max(seconds, 1e-6)
        # At most four times as many: one short episode proves little.
        self.episodes = max(1, min(round(wanted), 4 * episodes, MAX_TASK_EPISODES))


def run_missing(plan: Plan, store: Store, executor: Executor, workers: int, report: Report) -> None:
    """Run every episode of a plan that is not in the store.

    Raises:
        StoreError: rows cannot be written; those written before stay.
        EpisodeError: an episode failed; those that had finished are in the store.
        Exception: whatever ``report`` raises, between two writes.
    """
    pace = Pace()
    tasks, running = missing_tasks(plan, store, pace), dict[Future[Done], int]()
    # After an error the executor ends what is still running. Futures are not cancelled here: a
    # process pool that breaks sets an exception on each of them, which a cancelled one rejects.
    while True:
        for case_id, case, seeds in islice(tasks, TASKS_PER_WORKER * workers - len(running)):
            running[executor.submit(run_task, case, seeds)] = case_id
        if not running:
            return
        done, _ = wait(running, TICK, return_when=FIRST_COMPLETED)
        report([])
        # Failed tasks come last, because they end the run.
        failures = []
        for future in sorted(done, key=_has_failed):
            case_id, (seconds, rows, program, failure) = running.pop(future), future.result()
            store.add(case_id, rows, program)
            pace.learn(len(rows), seconds)
            report(rows)
            failures += [] if failure is None else [failure]
        if failures:
            raise EpisodeError(failures[0])


def missing_tasks(plan: Plan, store: Store, pace: Pace) -> Iterator[tuple[int, Case, list[int]]]:
    """Yield what is missing in tasks of the present size of ``pace``: the case and its seeds."""
    for case in plan.cases:
        case_id = store.case_id(case)
        seeds = _missing_seeds(store, case_id, plan.seeds)
        while some := list(islice(seeds, pace.episodes)):
            yield case_id, case, some


def _missing_seeds(store: Store, case_id: int, seeds: range) -> Iterator[int]:
    """Yield the seeds that are not in the store, looked up in parts to save memory."""
    for start in range(0, len(seeds), SEEDS_AT_ONCE):
        some = seeds[start : start + SEEDS_AT_ONCE]
        done = store.seeds_done(case_id, some)
        yield from (seed for seed in some if seed not in done)


def _has_failed(future: Future[Done]) -> bool:
    return future.exception() is not None or future.result().failure is not None
