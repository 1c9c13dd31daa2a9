"""Executors for episodes: processes of this machine or a Dask cluster, and their interrupts."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager
from types import FrameType

from agents.errors import ClusterError, WorkerError
from warehouse_core.extras import install_command

DEFERRED = (signal.SIGINT, signal.SIGTERM)

MAX_PROCESSES = 61 if sys.platform == "win32" else 1024
"""Of a pool; Windows can wait for no more at once."""

KILLED = (
    "a worker process was killed, perhaps because memory ran out; use fewer --workers, and run the "
    "same command again to resume"
)

Check = Callable[[], None]
"""Raises ``KeyboardInterrupt`` if a deferred signal has come."""

Pool = AbstractContextManager[tuple[Executor, int]]
"""Gives an executor, and how many calls it runs at once."""


@contextmanager
def deferred_interrupts() -> Iterator[Check]:
    """Defer SIGINT and SIGTERM to the calls of the function that is yielded."""
    came = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True

    def check() -> None:
        if came:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, remember) for number in DEFERRED}
    try:
        yield check
    finally:
        # After the first one the program is ending; further ones must not disturb that.
        for number, handler in before.items():
            signal.signal(number, signal.SIG_IGN if came else handler)


@contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Block SIGINT in this thread, so that processes started meanwhile inherit that.

    Ctrl-C goes to every process of a terminal, also to those that cannot ignore it yet. One that
    comes to this thread meanwhile is delivered at the end.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows: workers ignore it once they have started
        yield
        return
    from multiprocessing import resource_tracker

    # Started later, it would unblock the signal.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def process_pool(count: int) -> Iterator[tuple[Executor, int]]:
    """Yield a pool of ``count`` processes of this machine, and their number.

    If the block raises, they are killed at once.

    Raises:
        WorkerError: one of them was killed by something else.
    """
    count = min(count, MAX_PROCESSES)
    # Spawned on every system: a fork of a process that has threads may hang.
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(count, mp_context=context, initializer=_start_worker) as pool:
        try:
            with blocked_interrupts():
                for _ in range(count):  # each call starts a process
                    pool.submit(os.getpid)
            yield pool, count
        except BaseException as error:
            for process in set(multiprocessing.active_children()) - others:
                process.kill()
            if isinstance(error, BrokenProcessPool):
                raise WorkerError(KILLED) from error
            raise


def _start_worker() -> None:
    """Ignore interrupts, and end with the parent process in whatever way it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker is started by another process"
    parent.join()
    os._exit(1)


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Yield the Dask cluster whose scheduler is at ``tcp://HOST:PORT``, and its threads.

    Raises:
        ClusterError: Dask is not installed, no scheduler answers, or the cluster fails.
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
            client = stack.enter_context(Client(address, timeout="10s"))
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler answers at {address}: {error}") from error
        threads = sum(client.nthreads().values())
        if not threads:
            raise ClusterError(f"the Dask scheduler at {address} has no workers")
        try:
            yield client.get_executor(pure=False, retries=3), threads
        except (CancelledError, KilledWorker, CommClosedError) as error:
            why = str(error) or type(error).__name__
            raise ClusterError(
                f"the Dask cluster at {address} has failed: {why}; run the same command again "
                "to resume"
            ) from error
