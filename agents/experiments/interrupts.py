"""Ctrl-C, or a polite end by whoever manages the machine, remembered until it suits.

An exception in the middle of handing work over or of starting a process would leave half of it
done. While a sweep runs, an interrupt is only noted; the sweep asks for it between two steps.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

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
