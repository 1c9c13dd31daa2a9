"""A check that a robot sees as far as a network did in its training."""

from __future__ import annotations

from agents.errors import AgentError
from warehouse_core.task.state import Observation


def check_view_radius(observation: Observation, trained: int, name: str) -> None:
    """Raise unless a robot sees as far as a network did in its training.

    Args:
        observation: observation of the robot.
        trained: view radius of the training.
        name: name of the network in the message.

    Raises:
        AgentError: the view radius differs from the training.
    """
    radius = len(observation["local_grid"]) // 2
    if radius != trained:
        raise AgentError(f"{name} was trained with view radius {trained}; this robot has {radius}")
