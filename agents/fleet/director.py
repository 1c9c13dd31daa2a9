"""What an agent that directs a fleet may have besides ``reset`` and ``act``."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from warehouse_core.records import FleetAgent


@runtime_checkable
class Dispatching(Protocol):
    """An agent that says who assigns the orders.

    Attributes:
        dispatch: true if the fleet does, see ``FleetEnv``; false if the agent does.
    """

    dispatch: bool


def wants_dispatch(agent: FleetAgent) -> bool:
    """Return whether a fleet assigns its orders itself, as it does unless its agent says no."""
    return agent.dispatch if isinstance(agent, Dispatching) else True
