"""A Dask cluster that runs episodes."""

from __future__ import annotations

import logging
import math
import os
import threading
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import ExitStack, contextmanager, suppress
from time import monotonic, sleep, time
from typing import TYPE_CHECKING, Any

from agents.errors import ClusterError
from agents.lab.console.terminal import print_error
from agents.lab.trials.workers import TOPIC
from warehouse_core.extras import install_command

if TYPE_CHECKING:
    from distributed import Client

ANSWER_SECONDS = 10.0
"""Longest time in which a scheduler must answer, and a worker must run a call that does nothing."""

SILENT_SECONDS = 10.0
"""Time without any worker until that is reported, or without an answer until one counts as gone."""


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Yield the Dask cluster whose scheduler is at ``tcp://HOST:PORT``, and its threads.

    A call that does not return occupies its worker even after its client has gone. Such workers
    are restarted; those without a nanny cannot be restarted and are retired. All that goes wrong
    is a ``ClusterError``.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm import CommClosedError
    except ImportError:
        raise ClusterError(f"a cluster needs Dask: {install_command('cluster')}") from None
    with ExitStack() as stack:
        # Dask would log tracebacks of errors that are reported in one line.
        stack.callback(logging.disable, logging.root.manager.disable)
        logging.disable()
        try:
            client = stack.enter_context(Client(address, timeout=ANSWER_SECONDS))
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler answers at {address}: {error}") from error
        try:
            client.subscribe_topic(TOPIC, lambda event: print_error(event[1]))
            _free_workers(client)
            threads = sum(client.nthreads().values())
            if not threads:
                raise ClusterError(f"the Dask scheduler at {address} has no workers")
            stack.enter_context(_silence_reported(client, address))
            yield client.get_executor(pure=False, retries=3), threads
        except (CancelledError, KilledWorker, CommClosedError) as error:
            why = str(error) or type(error).__name__
            raise ClusterError(
                f"the Dask cluster at {address} has failed: {why}; run the same command again "
                "to resume"
            ) from error


def _free_workers(client: Client) -> None:
    """Restart or retire the workers that are occupied by calls whose clients have gone."""
    probes = {
        worker: client.submit(os.getpid, workers=[worker], pure=False)
        for worker in client.nthreads()
    }
    end = monotonic() + ANSWER_SECONDS
    while not all(probe.done() for probe in probes.values()) and monotonic() < end:
        sleep(0.01)
    calls, results = client.processing(), client.has_what()
    for worker, probe in probes.items():
        # One that is busy with calls of other clients, or keeps results for them, is left alone.
        if probe.done() or {*calls.get(worker, ())} != {probe.key} or results.get(worker):
            continue
        try:
            client.restart_workers([worker])
            outcome = "restarted"
        except ValueError:  # it has no nanny
            client.retire_workers([worker])
            outcome = "retired, as it has no nanny to restart it; start another in its place"
        print_error(
            f"the Dask worker {worker} was occupied by a call of an ended client: {outcome}"
        )


@contextmanager
def _silence_reported(client: Client, address: str) -> Iterator[None]:
    """Report that there have been no workers for some seconds, once each time."""
    ended = threading.Event()

    def count_workers(dask_scheduler: Any) -> int:  # in the scheduler
        oldest = time() - SILENT_SECONDS
        return sum(worker.last_seen > oldest for worker in dask_scheduler.workers.values())

    def watch() -> None:
        since = monotonic()
        with suppress(Exception):  # the sweep has the error too
            while not ended.wait(1):
                if client.run_on_scheduler(count_workers):
                    since = monotonic()
                elif monotonic() - since > SILENT_SECONDS:
                    since = math.inf
                    print_error(
                        f"no workers for {SILENT_SECONDS:g} s on the Dask cluster at {address}; "
                        "the sweep goes on when there are some, such as by "
                        f"'dask worker {address}'; Ctrl-C ends it"
                    )

    # Not waited for: a scheduler may not answer.
    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        ended.set()
