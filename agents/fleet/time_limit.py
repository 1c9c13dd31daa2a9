"""A limit on the time that a block of code takes."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager

raise_in_thread = ctypes.pythonapi.PyThreadState_SetAsyncExc
raise_in_thread.argtypes = (ctypes.c_ulong, ctypes.py_object)


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise ``TimeoutError`` in the block once it has taken so many seconds by the clock.

    It is raised between two instructions of Python, so that one call of compiled code may take
    longer. Any thread may use it.
    """
    thread, lock, is_over = threading.get_ident(), threading.Lock(), False

    def cut_off() -> None:
        with lock:
            if not is_over:
                raise_in_thread(thread, TimeoutError)

    timer = threading.Timer(seconds, cut_off)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        with lock:
            is_over = True
        timer.cancel()
