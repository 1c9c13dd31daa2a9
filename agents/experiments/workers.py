"""Who runs the episodes: this machine's processes or a Dask cluster, behind one executor."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker

from agents.experiments.interrupts import uninterrupted_children


class ClusterError(Exception):
    """A cluster that cannot be reached or used; the message says why."""


@contextmanager
def processes(count: int) -> Iterator[tuple[Executor, int]]:
    """Yield a pool of ``count`` processes of this machine, and how many they are.

    Whatever ends the block early ends them at once: what they are at is run again next time.
    """
    # Spawned, as on every system: a fork of a process that has threads may hang.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(count, mp_context=context, initializer=_begin) as pool:
        # Its start would unblock the interrupts that are about to be blocked.
        resource_tracker.ensure_running()
        with uninterrupted_children():
            for _ in range(count):  # each is started for the work it is given
                pool.submit(_begin_nothing)
        try:
            yield pool, count
        except BaseException:
            for process in multiprocessing.active_children():
                process.kill()
            raise


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Yield the Dask cluster whose scheduler is at ``tcp://HOST:PORT``, and its threads.

    Raises:
        ClusterError: Dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ClusterError("a cluster needs Dask: pip install 'warehouse-lab[cluster]'") from None
    try:
        client = Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise ClusterError(f"no Dask scheduler answers at {address}: {error}") from error
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise ClusterError(f"the Dask scheduler at {address} has no workers")
        yield client.get_executor(pure=False, retries=3), threads


def _begin() -> None:
    """Ignore interrupts, and end with the process that started this one, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker has been started by another process"
    parent.join()
    os._exit(1)


def _begin_nothing() -> None:
    """Do nothing."""
