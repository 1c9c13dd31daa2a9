"""Worker processes that run episodes, and the handling of interrupts."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from functools import partial
from itertools import product
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from types import FrameType
from typing import Any, TypeVar

from agents.errors import WorkerError

DEFERRED = (signal.SIGINT, signal.SIGTERM)

ENDING_SECONDS = 5.0
"""Seconds after which a process that was asked to end, or has closed its connection, is killed."""

CheckInterrupt = Callable[[], None]
"""Function that raises ``KeyboardInterrupt`` if a deferred signal has arrived."""

T = TypeVar("T")
Group = TypeVar("Group")


@contextmanager
def deferred_interrupts() -> Iterator[CheckInterrupt]:
    """Defer SIGINT and SIGTERM until the yielded function is called."""
    has_arrived = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal has_arrived
        has_arrived = True

    def check() -> None:
        if has_arrived:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, remember) for number in DEFERRED}
    try:
        yield check
    finally:
        # After the first signal the program is ending, which further signals must not disturb.
        for number, handler in before.items():
            signal.signal(number, signal.SIG_IGN if has_arrived else handler)


@contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Block SIGINT in this thread, so that processes started meanwhile inherit the block.

    Ctrl-C reaches every process of a terminal, including new processes that do not ignore it yet.
    A SIGINT that arrives in this thread meanwhile is delivered at the end of the block.
    """
    if not hasattr(signal, "pthread_sigmask"):  # on Windows workers ignore it after they start
        yield
        return
    from multiprocessing import resource_tracker

    # If the tracker started later, it would unblock the signal.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Processes(ThreadPoolExecutor):
    """An executor that runs each call in one of ``count`` processes, which start when needed.

    A thread for each process waits for its results. If a process ends, only the call that it was
    running fails, with an error that says how the process ended, and the process is replaced. All
    processes end with their parent. A process that needs more than ``seconds`` for a call is ended;
    ``None`` is no limit.

    A ``ProcessPoolExecutor`` has none of these properties. There, one process that ends makes every
    call fail, and processes outlive a parent that is killed.
    """

    def __init__(self, count: int, seconds: float | None = None) -> None:
        super().__init__(count)
        self._processes = [_Process(seconds) for _ in range(count)]
        self._idle = SimpleQueue[_Process]()
        for process in self._processes:
            self._idle.put(process)

    def submit(self, call: Callable[..., T], /, *args: Any, **named: Any) -> Future[T]:
        """Submit a call; its future raises ``WorkerError`` if the process ends meanwhile."""
        return super().submit(self._run, partial(call, *args, **named))

    def __exit__(self, *error: object) -> None:
        """Cancel the waiting calls and end the processes, even if they are still running calls."""
        self.shutdown(wait=False, cancel_futures=True)
        for process in self._processes:
            process.terminate()
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
    """A process that runs calls; if it ends, a new one is started for the next call."""

    def __init__(self, seconds: float | None) -> None:
        self._lock, self._is_closed, self._seconds = threading.Lock(), False, seconds
        self._process: BaseProcess | None = None

    def run(self, call: Callable[[], Any]) -> Any:
        """Run a call in the process, and return its result."""
        if self._process is None:
            self._start()
        try:
            self._connection.send(call)
            if not self._connection.poll(self._seconds):
                self.close()
                raise WorkerError(f"its process was ended after {self._seconds:,.0f} s")
            result, error = self._connection.recv()
        except (EOFError, OSError):
            raise WorkerError(self._reason()) from None
        if error is not None:
            raise error
        return result

    def terminate(self) -> None:
        """Ask the process to end, and do not start another one."""
        with self._lock:
            self._is_closed = True
            if self._process is not None:
                self._process.terminate()

    def close(self) -> int:
        """Wait for the end of the process, kill it if it does not end in time, return its code."""
        with self._lock:
            if self._process is None:
                return 0
            self._process.terminate()
            self._process.join(ENDING_SECONDS)
            self._process.kill()
            self._process.join()
            # Another thread that starts a process may be about to collect the exit code.
            while (code := self._process.exitcode) is None:
                time.sleep(0.001)
            self._process = None
            return code

    def _start(self) -> None:
        # Spawned on every system, because a fork of a process that has threads may hang.
        context = multiprocessing.get_context("spawn")
        with self._lock, blocked_interrupts():
            if self._is_closed:
                raise WorkerError("the sweep has ended")
            self._connection, theirs = context.Pipe()
            process = context.Process(target=_work, args=(theirs,))
            process.start()
            self._process = process
            theirs.close()  # so that the connection ends when the process ends

    def _reason(self) -> str:
        """Return a description of how the process has ended."""
        if self._process is not None:
            self._process.join(ENDING_SECONDS)  # unless an agent has only closed its files
        code = self.close()
        if code >= 0:
            return f"its process ended with exit code {code}"
        why = ", perhaps because memory ran out" if code == -signal.SIGKILL else ""
        return f"its process was ended by signal {-code} ({signal.strsignal(-code)}){why}"


def _work(parent: Connection[Any, Any]) -> None:
    """Run the calls that the parent process sends, and end when it ends, however it ends."""
    is_over = threading.Event()

    def interrupt(number: int, frame: FrameType | None) -> None:
        # Once only, so that the call can remove its files and end its processes.
        signal.signal(number, signal.SIG_IGN)
        is_over.set()
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        signal.signal(signal.SIGTERM, interrupt)  # here, because it raises KeyboardInterrupt
        while True:
            call = parent.recv()
            result, error = None, None
            try:
                result = call()
            except Exception as raised:
                error = raised
            if is_over.is_set():
                raise KeyboardInterrupt  # once more, because the call has caught it
            parent.send((result, error))
    except (EOFError, OSError):
        pass
    except KeyboardInterrupt:
        os._exit(1)  # a call may have left threads, for which the interpreter would wait


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker is started by another process"
    parent.join()
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(ENDING_SECONDS)
    os._exit(1)


def run_trials(
    call: Callable[[Group, int], T],
    groups: Sequence[Group],
    seeds: Sequence[int],
    jobs: int | None,
    label: str = "runs",
) -> dict[Group, list[T]]:
    """Run a call for each group and each seed in parallel, with a progress bar.

    Args:
        call: function of a group and a seed, defined at the top level of its module.
        groups: first arguments of the call.
        seeds: second arguments, the same for each group.
        jobs: number of processes. By default there is one for each processor; with 1 the calls run
            in this process.
        label: label of the progress bar.

    Returns:
        Results for each group, in the order of the seeds.

    Raises:
        WorkerError: a process has ended. Errors of a call are raised as they are.
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
