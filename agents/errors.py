"""Errors of agents and experiments that a user can cause.

::

    WarehouseError          (warehouse_core/errors.py)
    |-- AgentError      (ValueError)    an agent by name, or a file, class or model of one
    |-- ParameterError  (ValueError)    a parameter of an experiment, or its value
    |-- PlanError       (ValueError)    a problem of several robots, or a plan that solves it
    |-- EpisodeError                    an episode that could not be run
    |-- StoreError                      a file of results
    |-- GradeError                      a rubric, or what grading needs
    +-- WorkerError                     a process that ended early
"""

from __future__ import annotations

import inspect
import traceback
from pathlib import Path
from typing import Any

from warehouse_core.errors import WarehouseError

__all__ = [
    "AgentError",
    "EpisodeError",
    "EpisodeInterrupted",
    "GradeError",
    "ParameterError",
    "PlanError",
    "StoreError",
    "WorkerError",
]


class AgentError(WarehouseError, ValueError):
    """An agent that does not exist or cannot be made; the message says why.

    Example:
        >>> from agents.registry import make_agent
        >>> make_agent("greedier")
        Traceback (most recent call last):
            ...
        agents.errors.AgentError: no agent is called 'greedier'; allowed: random, reflex, ...
    """


class ParameterError(WarehouseError, ValueError):
    """An unknown parameter of an experiment, or a value that is not allowed.

    Example:
        >>> from agents.lab.experiments.plan import make_plan
        >>> make_plan({"memory": [-1]}, episodes=10, seed=1)
        Traceback (most recent call last):
            ...
        agents.errors.ParameterError: memory is -1; allowed: a whole number 0..1000000000
    """


class PlanError(WarehouseError, ValueError):
    """A problem with several robots that has no plan, or for which no plan was found in time.

    Example:
        >>> from agents.mapf.graph import Graph
        >>> from agents.mapf.problem import Problem
        >>> from warehouse_core import Layout
        >>> Problem(Graph(Layout([".#."])), starts=[0], goals=[2])
        Traceback (most recent call last):
            ...
        agents.errors.PlanError: robot 0: no path exists from (0, 0) to (0, 2)
    """


class EpisodeError(WarehouseError):
    """An episode that failed; ``episode`` is its record so far, or ``None``.

    Example:
        >>> from agents.lab.runs.run import run
        >>> from warehouse_core import WarehouseEnv
        >>> class Failing:
        ...     def reset(self):
        ...         pass
        ...
        ...     def act(self, observation):
        ...         return observation["compass"]
        >>> run(WarehouseEnv(), Failing(), seed=1)
        Traceback (most recent call last):
            ...
        agents.errors.EpisodeError: seed 1, step 1, agent Failing: KeyError: 'compass' ...
    """

    def __init__(self, message: str, episode: Any = None) -> None:
        super().__init__(message)
        self.episode = episode


class EpisodeInterrupted(KeyboardInterrupt):
    """An interrupt during an episode; ``episode`` is its record so far.

    Example:
        >>> from agents.errors import EpisodeInterrupted
        >>> from agents.lab.runs.run import run
        >>> from warehouse_core import WarehouseEnv
        >>> class Interrupted:
        ...     def reset(self):
        ...         pass
        ...
        ...     def act(self, observation):
        ...         raise KeyboardInterrupt
        >>> try:
        ...     run(WarehouseEnv(), Interrupted(), seed=1)
        ... except EpisodeInterrupted as interrupt:
        ...     interrupt.episode.steps
        0
    """

    def __init__(self, message: str, episode: Any) -> None:
        super().__init__(message)
        self.episode = episode


class StoreError(WarehouseError):
    """A file of results that cannot be read or written; the message says why.

    Example:
        >>> from agents.lab.experiments.store import Store
        >>> Store("results.sqlite", read_only=True)
        Traceback (most recent call last):
            ...
        agents.errors.StoreError: results.sqlite: there is no such file
    """


class GradeError(WarehouseError):
    """A rubric that cannot be used, or a condition of grading that is not met.

    Example:
        >>> from pathlib import Path
        >>> from agents.lab.grading.rubric import load_rubric
        >>> size = Path("rubric.toml").write_text('title = "No cases"')
        >>> load_rubric(Path("rubric.toml"))
        Traceback (most recent call last):
            ...
        agents.errors.GradeError: rubric.toml: there are no [cases.NAME]; a rubric needs episodes
    """


class WorkerError(WarehouseError):
    """A worker process that ended before its work was done.

    Example:
        >>> import os
        >>> from agents.lab.trials.workers import Processes
        >>> with Processes(1) as pool:
        ...     pool.submit(os._exit, 1).result()
        Traceback (most recent call last):
            ...
        agents.errors.WorkerError: its process ended with exit code 1
    """


class PyodideError(WarehouseError):
    """A file of Pyodide that cannot be read, or belongs to another version."""


def reason_of(error: BaseException, file: Path | None = None) -> str:
    """Return the class, the message and the last line of an exception, in ``file`` if given."""
    frames = frames_in(file, error)
    where = "".join(f" ({Path(each.filename).name}, line {each.lineno})" for each in frames[-1:])
    try:
        text = f": {error}" if str(error) else ""
    except Exception:  # a user's exception may itself be broken
        text = ""
    return f"{type(error).__name__}{text}{where}"


def frames_in(file: Path | None, error: BaseException) -> list[traceback.FrameSummary]:
    """Return the frames of the traceback of an exception; with a ``file``, only its frames."""
    return [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if file is None or Path(frame.filename).resolve() == file.resolve()
    ]


def file_of(thing: object) -> Path | None:
    """Return the file that defines the class of an object, or ``None`` if it has no file."""
    try:
        return Path(inspect.getfile(type(thing)))
    except (OSError, TypeError):
        return None
