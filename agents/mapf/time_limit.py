"""A limit on the run time of a block of code."""

from __future__ import annotations

import ctypes
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LOOK_SECONDS = 0.02
"""Seconds between two looks at the clock."""

NO_THREADS = "threads cannot be started or interrupted here, so planners have no time limit"


class Watcher:
    """One thread that watches the blocks of all other threads, as starting threads is slow."""

    def __init__(self) -> None:
        self._lock, self._ends = threading.Lock(), dict[int, float]()
        self._thread, self._can_start = threading.Thread(), True

    @contextmanager
    def time_limit(self, seconds: float) -> Iterator[None]:
        """Raise ``TimeoutError`` in the block when it has run for this many seconds by the clock.

        The error is raised between two Python instructions, so that a call of compiled code may
        exceed the limit. Any thread may use it. If threads cannot be started or interrupted, as in
        a browser, no limit applies, and a warning says so once.
        """
        here = threading.get_ident()
        with self._lock:
            self._ends[here] = time.monotonic() + seconds
            # Needed for the first block, and in a forked process.
            if self._can_start and not self._thread.is_alive():
                self._start()
        try:
            yield
        finally:
            with self._lock:
                self._ends.pop(here, None)

    def _start(self) -> None:
        try:
            # Some builds of CPython have no ``pythonapi``.
            interrupt = ctypes.pythonapi.PyThreadState_SetAsyncExc
            self._thread = threading.Thread(target=self._watch, args=(interrupt,), daemon=True)
            self._thread.start()
        except (AttributeError, RuntimeError):
            self._can_start = False
            warnings.warn(NO_THREADS, RuntimeWarning, stacklevel=4)

    def _watch(self, interrupt: Callable[..., int]) -> None:
        while True:
            time.sleep(LOOK_SECONDS)
            now = time.monotonic()
            with self._lock:
                for thread, end in list(self._ends.items()):
                    if end < now:
                        del self._ends[thread]
                        interrupt(ctypes.c_ulong(thread), ctypes.py_object(TimeoutError))


time_limit = Watcher().time_limit
