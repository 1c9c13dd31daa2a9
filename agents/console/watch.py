"""Watch an agent during an episode: where it fails, is interrupted, or takes long."""

from __future__ import annotations

import inspect
import math
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from agents.console.terminal import say
from agents.errors import EpisodeError, EpisodeInterrupted, reason_of
from warehouse_core import Agent, Episode, EpisodeRecorder, Observation

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
    episode, file = recorder.episode, _source_of(agent)
    try:
        with _slow_steps_reported(episode, name, file):
            recorder.run(agent, observation)
    except KeyboardInterrupt as error:
        reason = reason_of(error, file).removeprefix("KeyboardInterrupt")
        raise EpisodeInterrupted(f"in {_place(episode, name)}{reason}", episode) from error
    except (Exception, SystemExit) as error:  # an agent may raise anything
        message = f"seed {episode.seed}, {_place(episode, name)}: {reason_of(error, file)}"
        raise EpisodeError(message, episode) from error


def _place(episode: Episode, name: str) -> str:
    return f"step {episode.steps + 1}, agent {name}"


def _source_of(agent: Agent) -> Path | None:
    try:
        return Path(inspect.getfile(type(agent)))
    except (OSError, TypeError):  # a class defined interactively
        return None


@contextmanager
def _slow_steps_reported(episode: Episode, name: str, file: Path | None) -> Iterator[None]:
    ended, thread = threading.Event(), threading.get_ident()

    def watch() -> None:
        steps, since = 0, monotonic()
        while not ended.wait(LOOK_SECONDS):
            if episode.steps != steps:
                steps, since = episode.steps, monotonic()
            elif monotonic() - since > SLOW_SECONDS:
                since = math.inf  # one report a step
                say(
                    f"warehouse: {_place(episode, name)} takes more than {SLOW_SECONDS:g} s"
                    f"{_line_of(thread, file)}; Ctrl-C ends it",
                    error=True,
                )

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
