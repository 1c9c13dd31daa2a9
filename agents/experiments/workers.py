"""Who runs the episodes: this machine's processes or a Dask cluster, behind one executor."""

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
from contextlib import AbstractContextManager, contextmanager
from types import FrameType

from agents.errors import ClusterError, WorkerError

REMEMBERED = (signal.SIGINT, signal.SIGTERM)

Check = Callable[[], None]
"""Raises ``KeyboardInterrupt`` if the end has been asked for."""


@contextmanager
def remembered_interrupts() -> Iterator[Check]:
    """Yield what raises ``KeyboardInterrupt`` if one of them came since this began."""
    came = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True

    def check() -> None:
        if came:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, remember) for number in REMEMBERED}
    try:
        yield check
    finally:
        # Who has asked for the end once is heard; more of it would only disturb the leaving.
        for number, handler in before.items():
            signal.signal(number, signal.SIG_IGN if came else handler)


@contextmanager
def uninterrupted_children() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach; this one gets it afterwards.

    Ctrl-C goes to every process of a terminal, from its first moment on. A blocked signal is
    inherited as such, and one that comes to this process meanwhile is only late.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows: what a worker ignores it ignores later
        yield
        return
    from multiprocessing import resource_tracker

    # Its start would unblock the interrupts again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


Hands = AbstractContextManager[tuple[Executor, int]]
"""Gives what runs calls, and how many it runs at once."""


MOST = 61 if sys.platform == "win32" else 1024
"""Processes of a pool; Windows can wait for no more at once."""


@contextmanager
def processes(count: int) -> Iterator[tuple[Executor, int]]:
    """Yield a pool of ``count`` processes of this machine, and how many they are.

    Whatever ends the block early ends them at once: what they are at is run again next time.

    Raises:
        WorkerError: one of them was killed.
    """
    count = min(count, MOST)
    # Spawned, as on every system: a fork of a process that has threads may hang.
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(count, mp_context=context, initializer=_begin) as pool:
        try:
            with uninterrupted_children():
                for _ in range(count):  # each is started for the work it is given
                    pool.submit(_begin_nothing)
            yield pool, count
        except BaseException as error:
            for process in set(multiprocessing.active_children()) - others:
                process.kill()
            if isinstance(error, BrokenProcessPool):
                raise WorkerError(KILLED) from error
            raise


KILLED = (
    "a worker process was ended in the middle, perhaps because the memory was used up, which fewer "
    "--workers would spare; the same command goes on"
)


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Yield the Dask cluster whose scheduler is at ``tcp://HOST:PORT``, and its threads.

    Raises:
        ClusterError: Dask is not installed, no scheduler answers, or it ends in the middle.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm import CommClosedError
    except ImportError:
        raise ClusterError("a cluster needs Dask: pip install 'warehouse-lab[cluster]'") from None
    with _without_logs():
        try:
            client = Client(address, timeout="10s")
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler answers at {address}: {error}") from error
        with client:
            threads = sum(client.nthreads().values())
            if not threads:
                raise ClusterError(f"the Dask scheduler at {address} has no workers")
            try:
                yield client.get_executor(pure=False, retries=3), threads
            except (CancelledError, KilledWorker, CommClosedError) as error:
                why = str(error) or type(error).__name__
                raise ClusterError(
                    f"the Dask cluster at {address} has gone: {why}; the same command goes on"
                ) from error


@contextmanager
def _without_logs() -> Iterator[None]:
    """Keep Dask from logging, with tracebacks, what is said in one line."""
    before = logging.root.manager.disable
    logging.disable()
    try:
        yield
    finally:
        logging.disable(before)


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
