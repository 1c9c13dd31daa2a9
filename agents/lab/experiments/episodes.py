"""Run the episodes of a case and return a row for each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from time import perf_counter
from typing import NamedTuple

from agents.errors import AgentError, EpisodeError, reason_of
from agents.fleet.director import wants_dispatch
from agents.lab.console.place import Stations, what_to_draw
from agents.lab.console.watch import slow_reported
from agents.lab.experiments.case import (
    FINGERPRINT,
    Case,
    agent_fingerprint,
    director_of,
    fleet_layout,
    in_words,
    is_fleet,
    make_agent_for,
    make_env,
    make_fleet,
    make_fleet_agent_for,
)
from agents.lab.runs.programs import program_for
from agents.lab.trials.rows import AnyRow, row_of
from agents.lab.trials.workers import teller
from agents.registry import agent_file
from warehouse_core import Episode, EpisodeRecorder
from warehouse_core.records.recorder import FleetRecorder

Recorder = EpisodeRecorder | FleetRecorder

SLOW_SECONDS = 10.0
"""Seconds of an episode before it is reported."""


class Done(NamedTuple):
    """The outcome of a task.

    Attributes:
        seconds: seconds that it took.
        rows: rows of its episodes, up to the one that failed.
        program: program that ran them, see ``program_for``.
        failure: the message of the error of the one that failed. It is text, because an exception
            of a user's agent may not be picklable.
    """

    seconds: float
    rows: list[AnyRow]
    program: str
    failure: str | None = None


class _Present:
    """The episode that a task is running, in words."""

    def __init__(self, case: Case, seed: int) -> None:
        self._case, self.seed = case, seed
        self.recorder: Recorder | None = None

    def __str__(self) -> str:
        place = "" if self.recorder is None else self.recorder.place
        return about(self._case, self.seed, place)


def run_task(case: Case, seeds: Sequence[int]) -> Done:
    """Run one episode for each seed, each in a new environment with a new agent, until one fails.

    The rows depend only on the case and the seeds. An episode that takes long is reported.
    """
    start, rows, failure = perf_counter(), list[AnyRow](), None
    program = program_for(case["backend"])
    try:
        check_fingerprint(case)
    except EpisodeError as error:
        return Done(perf_counter() - start, rows, program, str(error))
    present, file, tell = _Present(case, seeds[0]), agent_file(director_of(case)), teller()

    def tell_slow(seconds: float, line: str) -> None:
        tell(f"{present} has run for {seconds:g} s{line}")

    try:
        with slow_reported(lambda: present.seed, SLOW_SECONDS, file, tell_slow):
            for seed in seeds:
                present.seed, present.recorder = seed, None
                rows.append(row_of(run_one(case, seed, partial(setattr, present, "recorder"))))
    # User agents may raise anything, even SystemExit.
    except BaseException as error:
        own = isinstance(error, AgentError)  # its message says all
        failure = f"{present}: {error if own else reason_of(error, file)}"
    return Done(perf_counter() - start, rows, program, failure)


def about(case: Case, seed: int, place: str = "") -> str:
    """Return an episode in words: its seed, a place in it, and what is not the default."""
    return f"seed {seed}{place and f', {place},'} with {in_words(case)}"


def run_one(
    case: Case, seed: int, watch: Callable[[Recorder], object] = lambda recorder: None
) -> Episode:
    """Run one episode of a case and return its record; ``watch`` is given its recorder."""
    return (run_fleet if is_fleet(case) else run_alone)(case, seed, watch)


def run_fleet(
    case: Case, seed: int, watch: Callable[[Recorder], object] = lambda recorder: None
) -> Episode:
    """Run one episode of a fleet; see ``run_one``."""
    layout = fleet_layout(case, seed)
    agent = make_fleet_agent_for(case, seed, layout)
    with closing(make_fleet(case, layout, dispatch=wants_dispatch(agent))) as env:
        recorder = FleetRecorder(env, seed=seed, agent=director_of(case))
        watch(recorder)
        recorder.run(agent)
        return recorder.episode


def run_alone(
    case: Case, seed: int, watch: Callable[[Recorder], object] = lambda recorder: None
) -> Episode:
    """Run one episode of a lone robot; see ``run_one``."""
    randomize = what_to_draw(Stations(case["stations"]))
    with closing(make_env(case, seed)) as env:
        agent = make_agent_for(case, seed, env.layout)
        observation = env.reset(randomize, seed)
        recorder = EpisodeRecorder(env, seed=seed, agent=type(agent).__name__)
        watch(recorder)
        recorder.run(agent, observation)
        return recorder.episode


def check_fingerprint(case: Case) -> None:
    """Raise if the code of a case's agent is not that which the case was made with.

    Raises:
        EpisodeError: a file has changed, or cannot be read.
    """
    if FINGERPRINT not in case:
        return
    try:
        is_same = agent_fingerprint(case) == case[FINGERPRINT]
    except AgentError as error:
        raise EpisodeError(str(error)) from error
    except OSError as error:
        raise EpisodeError(f"the file of agent {director_of(case)!r}: {error.strerror}") from error
    if not is_same:
        name = director_of(case)
        what = "module" if agent_file(name) is None else "file"
        again = "; restart the workers of a cluster" if what == "module" else ""
        raise EpisodeError(
            f"the {what} of agent {name!r}, or what it imports, has changed since the "
            f"sweep began{again}"
        )
