"""Watch an agent during an episode: where it fails, is interrupted, or takes long."""

from __future__ import annotations

import inspect
import math
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from agents.errors import EpisodeError, EpisodeInterrupted, reason_of
from agents.lab.console.terminal import print_error
from warehouse_core import Agent, Episode, EpisodeRecorder, FleetEpisode, Observation

SLOW_SECONDS, LOOK_SECONDS = 5.0, 0.5
"""Seconds of a step before it is reported, and seconds between the checks."""


def run_watched(
    recorder: EpisodeRecorder, agent: Agent, name: str, observation: Observation
) -> None:
    """Reset an agent and let it act until the episode is over.

    A step that takes long is reported on standard error.

    Args:
        recorder: of the episode.
        agent: to be watched.
        name: of the agent.
        observation: the first one.

    Raises:
        EpisodeError: the agent raised an exception, or returned something that is no action.
        EpisodeInterrupted: Ctrl-C was pressed.
    """
    with watched(lambda: recorder.place, name, agent, lambda: recorder.episode):
        recorder.run(agent, observation)


@contextmanager
def watched(
    part: Callable[[], str],
    name: str,
    agent: object,
    record: Callable[[], Episode | FleetEpisode],
) -> Iterator[None]:
    """Name where an agent fails, is interrupted or takes long in a block.

    Args:
        part: gives the part of the episode that the block is in, such as ``"step 3"``.
        name: of the agent.
        agent: whose code is named.
        record: gives the record so far.

    Raises:
        EpisodeError: the block raised an exception.
        EpisodeInterrupted: Ctrl-C was pressed.
    """
    file = _source_of(agent)

    def place() -> str:
        return f"{part()}, agent {name}"

    def tell(seconds: float, line: str) -> None:
        print_error(f"{place()} takes more than {seconds:g} s{line}; Ctrl-C ends it")

    try:
        with slow_reported(part, SLOW_SECONDS, file, tell):
            yield
    except KeyboardInterrupt as error:
        reason = reason_of(error, file).removeprefix("KeyboardInterrupt")
        raise EpisodeInterrupted(f"in {place()}{reason}", record()) from error
    except (Exception, SystemExit) as error:  # an agent may raise anything
        episode = record()
        message = f"seed {episode.seed}, {place()}: {reason_of(error, file)}"
        raise EpisodeError(message, episode) from error


def _source_of(agent: object) -> Path | None:
    try:
        return Path(inspect.getfile(type(agent)))
    except (OSError, TypeError):  # a class defined interactively
        return None


@contextmanager
def slow_reported(
    part: Callable[[], object],
    seconds: float,
    file: Path | None,
    tell: Callable[[float, str], None],
) -> Iterator[None]:
    """Report the parts of a block that take long, once each.

    Args:
        part: gives the part that this thread is in.
        seconds: after which a part is reported.
        file: of the agent.
        tell: is called in another thread with ``seconds`` and the line of the file that is being
            executed, in words.
    """
    ended, thread = threading.Event(), threading.get_ident()

    def watch() -> None:
        last, since = part(), monotonic()
        while not ended.wait(LOOK_SECONDS):
            if (now := part()) != last:
                last, since = now, monotonic()
            elif monotonic() - since > seconds:
                since = math.inf  # one report a part
                tell(seconds, _line_of(thread, file))

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()


def _line_of(thread: int, file: Path | None) -> str:
    """Return the line of a file that a thread is executing, in words."""
    frame = sys._current_frames().get(thread)
    while frame is not None:
        if file is not None and Path(frame.f_code.co_filename) == file:
            return f" ({file.name}, line {frame.f_lineno})"
        frame = frame.f_back
    return ""
