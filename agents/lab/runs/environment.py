"""Environments of a lone robot by the name of a backend, and the controllers that they need."""

from __future__ import annotations

from typing import Any

from agents.learning.drive_policy import DrivePolicy
from agents.registry import make_agent, make_backend
from warehouse_core import BackendError, Cell, FleetEnv, Layout, WarehouseEnv
from warehouse_core.extras import not_installed
from warehouse_core.records.episode import DRIVE, is_drive


def make_env(
    backend: str,
    layout: Layout,
    start_pos: Cell | None,
    max_steps: int,
    battery: int,
    view_radius: int = 2,
    randomize: bool | str = True,
) -> Any:
    """Return a ``WarehouseEnv``, or a ``DriveEnv`` if the backend means continuous control.

    The arguments have the same meaning as for ``WarehouseEnv``. Under continuous control,
    ``max_steps`` and ``battery`` count moves over one cell, and ``randomize`` is used instead of
    the argument of ``reset``.

    Raises:
        BackendError: a setting is wrong, or a library is not installed.
    """
    if not is_drive(backend):
        made = make_backend(backend)
        return WarehouseEnv(layout, start_pos, max_steps, battery, view_radius, backend=made)
    try:
        from warehouse_physics.drive import DriveEnv
    except ImportError as error:
        raise BackendError(not_installed("backend 'drive' needs", error, "physics")) from error
    limits = {"moves": max_steps, "units": battery}
    try:
        return DriveEnv.from_name(
            backend, layout, start_pos=start_pos, randomize=randomize, **limits
        )
    except ValueError as error:
        raise BackendError(f"backend {backend!r}: {error}") from error


def backend_for(agent: str, backend: str) -> str:
    """Return the backend on which the agent with a name acts.

    For a trained policy the bare name ``drive`` stands for the environment of its training.
    """
    if backend != DRIVE or not is_drive(agent):
        return backend
    trained: Any = make_agent(agent)
    own: str = trained.backend
    return own


def controller_of(env: Any, agent: Any) -> Any:
    """Return what acts for an agent: a follower if a grid agent is to control a body."""
    if isinstance(env, (WarehouseEnv, FleetEnv)) or isinstance(agent, DrivePolicy):
        return agent
    from agents.drive.follower import Follower  # needs pymunk, as its environment does

    return Follower(env, agent)
