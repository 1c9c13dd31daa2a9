"""Runs of grid agents under continuous control."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

from agents.lab.runs.run import Watch, run
from agents.learning.drive_policy import DrivePolicy
from warehouse_core import Agent, BackendError, Episode
from warehouse_core.extras import install_command
from warehouse_core.records.episode import DRIVE


def is_drive(backend: str) -> bool:
    """Return whether the name of a backend means continuous control."""
    return backend.partition(":")[0] == DRIVE


def make_drive(backend: str, **arguments: Any) -> Any:
    """Return the ``DriveEnv`` with a name; see ``DriveEnv.from_name`` for the arguments.

    Raises:
        BackendError: a setting is wrong, or pymunk or Gymnasium is not installed.
    """
    try:
        from warehouse_physics.drive import DriveEnv
    except ImportError as error:
        raise BackendError(
            f"backend 'drive' needs {error.name}, which is not installed: "
            f"{install_command('physics')}"
        ) from error
    try:
        return DriveEnv.from_name(backend, **arguments)
    except ValueError as error:
        raise BackendError(f"backend {backend!r}: {error}") from error


def drive(
    backend: str,
    agent: Agent | DrivePolicy,
    seed: int,
    *,
    watch: Watch = nullcontext,
    **arguments: Any,
) -> Episode:
    """Return the record of an episode under continuous control.

    A trained policy drives by itself. A follower drives the moves of a grid agent.

    Args:
        backend: name of the environment; for a trained policy the bare name stands for the one in
            which it was trained.
        agent: grid agent or trained policy.
        seed: seed of the episode.
        watch: see ``run``.
        arguments: see ``make_drive``.

    Raises:
        EpisodeError: see ``run``.
    """
    if isinstance(agent, DrivePolicy) and backend == DRIVE:
        backend = agent.backend
    env = make_drive(backend, **arguments)  # says what is missing, before the next import fails
    from agents.drive.follower import Follower

    driver = agent if isinstance(agent, DrivePolicy) else Follower(env, agent)
    episode = run(env, driver, seed, watch, name=type(agent).__name__)
    episode.agent = type(agent).__name__
    return episode
