"""Reports of steps in which an agent takes a long time."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from time import monotonic

from agents.errors import file_of
from agents.lab.console.terminal import print_error
from agents.lab.runs.run import Watch, Whereabouts, own_code

SLOW_SECONDS, LOOK_SECONDS = 5.0, 0.5
"""Seconds after which a step is reported, and seconds between two checks."""


def slow_steps_reported(agent: object, name: str) -> Watch:
    """Return a watch that prints each slow step of an agent, and the line of code it is in."""
    file = file_of(own_code(agent))

    def watch(place: Whereabouts) -> AbstractContextManager[None]:
        def report(seconds: float, line: str) -> None:
            print_error(
                f"{place()}, agent {name} takes more than {seconds:g} s{line}; Ctrl-C stops it"
            )

        return slow_reported(place, SLOW_SECONDS, file, report)

    return watch


@contextmanager
def slow_reported(
    part: Callable[[], object],
    seconds: float,
    file: Path | None,
    report: Callable[[float, str], None],
) -> Iterator[None]:
    """Report each slow part of a block once.

    Args:
        part: function that returns the part that this thread is in.
        seconds: time after which a part is reported.
        file: file of the agent.
        report: function that another thread calls with ``seconds`` and the line of the file that
            is being executed, in words.
    """
    ended, thread = threading.Event(), threading.get_ident()

    def watch() -> None:
        last, since = part(), monotonic()
        while not ended.wait(LOOK_SECONDS):
            if (now := part()) != last:
                last, since = now, monotonic()
            elif monotonic() - since > seconds:
                since = math.inf  # one report for each part
                report(seconds, _line_of(thread, file))

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


def _line_of(thread: int, file: Path | None) -> str:
    """Return the line of a file that a thread is executing, in words, or "" if it is elsewhere."""
    frame = sys._current_frames().get(thread)
    while frame is not None:
        if file is not None and Path(frame.f_code.co_filename).resolve() == file.resolve():
            return f" ({file.name}, line {frame.f_lineno})"
        frame = frame.f_back
    return ""
