"""Run the episodes of a case and return a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from time import perf_counter
from typing import Any, NamedTuple

from agents.errors import AgentError, EpisodeError, EpisodeInterrupted, reason_of
from agents.fleet.planned import wants_dispatch
from agents.lab.console.watch import slow_reported
from agents.lab.experiments.case import (
    FINGERPRINT,
    Case,
    agent_fingerprint,
    director_of,
    in_words,
    is_fleet,
    layout_for,
    make_agent_for,
    make_env,
    randomize_for,
)
from agents.lab.runs.programs import program_for
from agents.lab.runs.run import Watch, Whereabouts, run
from agents.lab.trials.rows import AnyRow, row_of
from agents.lab.trials.workers import teller
from agents.registry import agent_file
from warehouse_core import Episode

SLOW_SECONDS = 10.0
"""Seconds that an episode may take before it is reported."""


class Done(NamedTuple):
    """The outcome of a task: its time, its episodes up to one that failed, and their program.

    A failure is text, because an exception of a user agent may not be picklable.
    """

    seconds: float
    rows: list[AnyRow]
    program: str
    failure: str | None = None


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
    file, tell = agent_file(director_of(case)), teller()
    nowhere: Whereabouts = str  # which returns ""
    seed, place = seeds[0], nowhere

    def present() -> str:
        return about(case, seed, place())

    def tell_slow(seconds: float, line: str) -> None:
        tell(f"{present()} has run for {seconds:g} s{line}")

    def watch(begun: Whereabouts) -> AbstractContextManager[None]:
        nonlocal place
        place = begun
        return nullcontext()

    try:
        with slow_reported(lambda: seed, SLOW_SECONDS, file, tell_slow):
            for seed in seeds:
                place = nowhere
                rows.append(row_of(run_one(case, seed, watch)))
    # User agents may raise anything, even SystemExit.
    except BaseException as error:
        cause = cause_of(error)
        is_clear = isinstance(cause, AgentError)  # its message says all
        failure = f"{present()}: {cause if is_clear else reason_of(cause, file)}"
    return Done(perf_counter() - start, rows, program, failure)


def about(case: Case, seed: int, place: str = "") -> str:
    """Return an episode in words: its seed, a place in it, and what is not the default."""
    return f"seed {seed}{place and f', {place},'} with {in_words(case)}"


def run_one(case: Case, seed: int, watch: Watch = nullcontext) -> Episode:
    """Run one episode of a case and return its record; for its errors see ``run``."""
    layout = layout_for(case, seed)
    agent: Any = make_agent_for(case, seed, layout)
    made: Any = make_env(case, layout, dispatch=is_fleet(case) and wants_dispatch(agent))
    with closing(made) as env:
        name, randomize = director_of(case), randomize_for(case)
        episode: Episode = run(env, agent, seed, watch, name=name, randomize=randomize)
        return episode


def cause_of(error: BaseException) -> BaseException:
    """Return what an agent has raised, if ``run`` has named where it did."""
    if isinstance(error, EpisodeError | EpisodeInterrupted) and error.episode is not None:
        return error.__cause__ or error
    return error


def check_fingerprint(case: Case) -> None:
    """Raise ``EpisodeError`` if the code of a case's agent has changed since the case was made."""
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
