"""Run the episodes of a case and return a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from time import perf_counter
from typing import NamedTuple

from agents.console.place import Stations, what_to_draw
from agents.errors import AgentError, EpisodeError, reason_of
from agents.experiments.case import (
    FINGERPRINT,
    Case,
    agent_fingerprint,
    flags_of,
    make_agent_for,
    make_env,
)
from agents.experiments.store import Row
from agents.programs import program_for
from agents.registry import agent_file
from warehouse_core import Episode, record_episode
from warehouse_core.records.failure_modes import diagnose


class Done(NamedTuple):
    """The outcome of a task.

    Attributes:
        seconds: that it took.
        rows: of its episodes, up to the one that failed.
        program: that ran them, see ``program_for``.
        failure: the message of the error of that one. It is text, because an exception of a user
            agent may not be picklable.
    """

    seconds: float
    rows: list[Row]
    program: str
    failure: str | None = None


def run_task(case: Case, seeds: Sequence[int]) -> Done:
    """Run one episode for each seed, each in a new environment with a new agent, until one fails.

    The rows depend only on the case and the seeds.
    """
    start, rows, failure = perf_counter(), list[Row](), None
    program = program_for(case["backend"])
    try:
        check_fingerprint(case)
    except EpisodeError as error:
        return Done(perf_counter() - start, rows, program, str(error))
    try:
        for seed in seeds:
            rows.append(row_of(run_one(case, seed)))
    # User agents may raise anything, even SystemExit.
    except BaseException as error:
        flags = ", ".join(flags_of(case)) or "the defaults"
        own = isinstance(error, AgentError)  # its message says all
        reason = str(error) if own else reason_of(error, agent_file(case["agent"]))
        failure = f"seed {seeds[len(rows)]} with {flags}: {reason}"
    return Done(perf_counter() - start, rows, program, failure)


def run_one(case: Case, seed: int) -> Episode:
    """Run one episode of a case and return its record."""
    randomize = what_to_draw(Stations(case["stations"]))
    with closing(make_env(case, seed)) as env:
        agent = make_agent_for(case, seed, env.layout)
        return record_episode(env, agent, seed=seed, randomize=randomize)


def row_of(episode: Episode) -> Row:
    """Return the row that is stored for an episode."""
    assert episode.seed is not None, "every episode here has a seed"
    diagnosis = diagnose(episode)
    cell = diagnosis.cells[0] if diagnosis.cells else episode.cells[-1]
    return Row(
        episode.seed,
        diagnosis.mode,
        episode.steps,
        diagnosis.needed,
        episode.total_reward,
        episode.battery[-1],
        episode.seconds,
        episode.joules,
        *cell,
    )


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
        raise EpisodeError(f"the file of agent {case['agent']!r}: {error.strerror}") from error
    if not is_same:
        what = "module" if agent_file(case["agent"]) is None else "file"
        again = "; restart the workers of a cluster" if what == "module" else ""
        raise EpisodeError(
            f"the {what} of agent {case['agent']!r}, or what it imports, has changed since the "
            f"sweep began{again}"
        )
