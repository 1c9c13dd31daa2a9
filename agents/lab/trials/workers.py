"""Processes of this machine that run episodes, and interrupts."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from functools import partial
from itertools import product
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from types import FrameType
from typing import Any, TypeVar

from agents.errors import WorkerError
from agents.lab.console.terminal import print_error

DEFERRED = (signal.SIGINT, signal.SIGTERM)

LOOK_SECONDS = 0.001
"""Seconds between two looks at a process that has ended."""

ENDING_SECONDS = 5.0
"""Time in which a process whose connection has ended must end."""

CheckInterrupt = Callable[[], None]
"""Raises ``KeyboardInterrupt`` if a deferred signal has come."""

T = TypeVar("T")
Group = TypeVar("Group")

_parent: Connection[Any, Any] | None = None
"""Connection of a worker process to the process that has started it."""


@contextmanager
def deferred_interrupts() -> Iterator[CheckInterrupt]:
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


class Processes(ThreadPoolExecutor):
    """Run each call in one of ``count`` processes of this machine, which start when needed.

    A thread for each process waits for its answers. A process that ends is an error of its own
    call alone, says how it has ended, and is replaced; it ends with the process that started it,
    and what a call tells is printed while the call runs. A ``ProcessPoolExecutor`` gives none of
    these: one process that ends is an error of every call, and others outlive a killed parent.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self._processes = [_Process() for _ in range(count)]
        self._idle = SimpleQueue[_Process]()
        for process in self._processes:
            self._idle.put(process)

    def submit(self, call: Callable[..., T], /, *args: Any, **named: Any) -> Future[T]:
        """Run a call; its future has a ``WorkerError`` if the process ends meanwhile."""
        return super().submit(self._run, partial(call, *args, **named))

    def __exit__(self, *error: object) -> None:
        """Cancel the calls that wait, and kill the processes, whatever they have left running."""
        self.shutdown(wait=False, cancel_futures=True)
        for process in self._processes:
            process.close()
        self.shutdown()

    def _run(self, call: Callable[[], T]) -> T:
        process = self._idle.get()
        try:
            result: T = process.run(call)
            return result
        finally:
            self._idle.put(process)


class _Process:
    """A process that runs calls, and is started again for the next call when it has ended."""

    def __init__(self) -> None:
        self._lock, self._is_closed = threading.Lock(), False
        self._process: BaseProcess | None = None

    def run(self, call: Callable[[], Any]) -> Any:
        """Return what a call returns, and print what it tells."""
        if self._process is None:
            self._start()
        try:
            self._connection.send(call)
            while isinstance(answer := self._connection.recv(), str):
                print_error(answer)
        except (EOFError, OSError):
            raise WorkerError(self._reason()) from None
        result, error = answer
        if error is not None:
            raise error
        return result

    def close(self) -> None:
        """Kill the process, and start no other."""
        with self._lock:
            self._is_closed = True
            if self._process is not None:
                self._process.kill()
                self._process.join()

    def _start(self) -> None:
        # Spawned on every system: a fork of a process that has threads may hang.
        context = multiprocessing.get_context("spawn")
        with self._lock, blocked_interrupts():
            if self._is_closed:
                raise WorkerError("the sweep has ended")
            self._connection, theirs = context.Pipe()
            process = context.Process(target=_work, args=(theirs,))
            process.start()
            self._process = process
            theirs.close()  # the end of the process is then the end of the connection

    def _reason(self) -> str:
        """Return how the process has ended."""
        with self._lock:
            assert self._process is not None, "it has run a call"
            self._process.join(ENDING_SECONDS)
            self._process.kill()  # if an agent has only closed its files
            self._process.join()
            # A thread that starts a process looks after all others, and may be about to know.
            while (code := self._process.exitcode) is None:
                time.sleep(LOOK_SECONDS)
            self._process = None
        if code >= 0:
            return f"its process ended with exit code {code}"
        why = ", perhaps because memory ran out" if code == -signal.SIGKILL else ""
        return f"its process was ended by signal {-code} ({signal.strsignal(-code)}){why}"


def _work(parent: Connection[Any, Any]) -> None:
    """Run the calls that come from the parent process, and end with it in whatever way it ends."""
    global _parent
    _parent = parent
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            call = parent.recv()
            result, error = None, None
            try:
                result = call()
            except Exception as raised:
                error = raised
            parent.send((result, error))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker is started by another process"
    parent.join()
    os._exit(1)


def teller() -> Callable[[str], None]:
    """Return a function that prints a line in the process that waits for the call."""
    return print_error if _parent is None else _parent.send


def run_trials(
    call: Callable[[Group, int], T],
    groups: Sequence[Group],
    seeds: Sequence[int],
    jobs: int | None,
    label: str = "runs",
) -> dict[Group, list[T]]:
    """Return what a call returns for each group, in the order of the seeds, which all share.

    A progress bar is shown. The first error of a call is raised, or a ``WorkerError`` if its
    process has ended. The call has to be at the top level of its module; ``jobs`` of 1 run it in
    this process, and by default there are as many as processors.
    """
    from agents.lab.console.progress import progress_bar, track

    trials = list(product(groups, seeds))
    count = jobs or os.cpu_count() or 1
    if count == 1:
        results = [call(*trial) for trial in track(trials, label)]
    else:
        with Processes(count) as pool, progress_bar(len(trials), label) as advance:
            futures = [pool.submit(call, *trial) for trial in trials]
            for number, future in enumerate(as_completed(futures), 1):
                future.result()
                advance(number)
        results = [future.result() for future in futures]
    starts = range(0, len(results), len(seeds))
    return {
        group: results[start : start + len(seeds)]
        for group, start in zip(groups, starts, strict=True)
    }
