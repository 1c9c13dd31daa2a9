"""The agent that ``warehouse train ppo`` trains; running it needs only NumPy.

It uses nothing but the observation.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from agents.errors import AgentError
from agents.learning.policy_network import PolicyNetwork, network_input
from agents.warehouse_agent_greedy import open_moves
from warehouse_core.task.encoding import FLEET_TILES, encode
from warehouse_core.task.rules import useful_actions
from warehouse_core.task.state import Observation
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import DROPOFF, EMPTY, MOVE_DELTAS, PICKUP


class PPOAgent:
    """Takes the useful action with the highest output of its network.

    With a network that robots of a fleet share, actions are drawn by their probability, as in
    training: robots that insist on the likeliest ones block each other for ever.

    Args:
        network: that chooses the actions.
        name: of the network in error messages.
        seed: for the actions that are drawn.
    """

    def __init__(
        self, network: PolicyNetwork, name: str = "the network", seed: int | None = None
    ) -> None:
        self._network, self._name = network, name
        is_shared = network.tiles == FLEET_TILES
        self._stream = np.random.default_rng(seed) if is_shared else None
        self.reset()

    @classmethod
    def load(cls, path: Path, seed: int | None = None) -> PPOAgent:
        """Return an agent with a network from a file.

        Raises:
            RecordError: the file is not one of a network.
            OSError: the file cannot be read.
        """
        return cls(PolicyNetwork.load(path), str(path), seed)

    def reset(self) -> None:
        """Prepare for an episode; the agent remembers nothing."""
        self.reason = ""

    def act(self, observation: Observation) -> str:
        """Return the action for ``observation`` and set ``reason`` to its probability.

        Raises:
            AgentError: the view radius is not that of the training.
        """
        radius = len(observation["local_grid"]) // 2
        if radius != self._network.view_radius:
            raise AgentError(
                f"{self._name} was trained with view radius {self._network.view_radius}; "
                f"this robot has {radius}"
            )
        logits = self._network.logits(network_input(encode(observation), self._network.tiles))
        allowed = np.where(useful_now(observation), logits, -np.inf)
        action = int(allowed.argmax())
        likelihoods = np.exp(np.float64(allowed - allowed[action]))
        likelihoods /= likelihoods.sum()
        if self._stream is not None:
            action = int(self._stream.choice(len(ACTIONS), p=likelihoods))
        self.reason = f"{100 * likelihoods[action]:.0f}% sure"
        return ACTIONS[action]


def useful_now(observation: Observation) -> tuple[bool, ...]:
    """Return for each action whether it would have an effect, judged by the observation."""
    moves = open_moves(observation["local_grid"])
    stations = {observation["dropoff_pos"]: DROPOFF, observation["pickup_pos"]: PICKUP}
    tile = stations.get(observation["robot_pos"], EMPTY)
    return useful_actions(
        tuple(move in moves for move in MOVE_DELTAS), tile, observation["has_item"]
    )
