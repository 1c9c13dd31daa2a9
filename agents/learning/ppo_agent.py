"""The agent that ``warehouse train ppo`` trains; running it needs only NumPy.

It uses only its observations.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from agents.errors import AgentError
from agents.learning.map_memory import SingleFloats
from agents.learning.policy_network import PolicyNetwork, network_input
from agents.warehouse_agent_greedy import open_moves
from warehouse_core.arguments import flag, instance_of, real_number, seed_number
from warehouse_core.task.encoding import FLEET_TILES, encode
from warehouse_core.task.rules import useful_actions
from warehouse_core.task.state import Observation
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tiles import DROPOFF, EMPTY, MOVE_DELTAS, PICKUP, Cell, moved


class PPOAgent:
    """An agent that takes the useful action with the highest output of its network.

    The network sees only nearby cells and remembers nothing. In a layout that it was not trained
    for, the agent may therefore go round in circles. Sampling actions breaks such loops by chance.
    A penalty for revisiting cells breaks them with certainty; it counts visits since the start of
    the episode or since the pickup.

    Args:
        network: network that chooses the actions.
        name: name of the network in error messages.
        seed: seed of the sampled actions, restarted at each ``reset``.
        sample: sample actions by their probability, as in training. ``None`` is true for a network
            that the robots of a fleet share, because robots that insist on the likeliest actions
            block each other forever.
        revisit: penalty, at least 0, for each visit to a cell, on the output of the actions that
            lead there.

    Attributes:
        samples: true if actions are sampled.
        revisit: the argument.

    Raises:
        AgentError: a value is not allowed.

    Example:
        >>> import numpy as np
        >>> from agents import PPOAgent
        >>> from agents.learning.policy_network import PolicyNetwork, input_size
        >>> from warehouse_core import WarehouseEnv
        >>> widths = [input_size(view_radius=2), 8, 8, 7]
        >>> layers = [(np.zeros((b, a)), np.zeros(b)) for a, b in zip(widths, widths[1:])]
        >>> PPOAgent(PolicyNetwork(2, layers)).act(WarehouseEnv().reset())  # not trained
        'E'
    """

    def __init__(
        self,
        network: PolicyNetwork,
        name: str = "the network",
        seed: int | None = None,
        sample: bool | None = None,
        revisit: float = 0.0,
    ) -> None:
        self._network = instance_of("network", network, PolicyNetwork)
        self._name = instance_of("name", name, str)
        try:
            sample = None if sample is None else flag("sample", sample)
            self.revisit, self._seed = real_number("revisit", revisit), seed_number(seed)
        except (TypeError, ValueError) as error:
            raise AgentError(f"{name}: {error}") from None
        self.samples = network.tiles == FLEET_TILES if sample is None else sample
        self.reset()

    @classmethod
    def load(
        cls, path: Path, seed: int | None = None, sample: bool | None = None, revisit: float = 0.0
    ) -> PPOAgent:
        """Return an agent with a network from a file; see the class for the other arguments.

        Raises:
            AgentError: as for the class.
            RecordError: the file does not contain a network.
            OSError: the file cannot be read.
        """
        return cls(PolicyNetwork.load(path), str(path), seed, sample, revisit)

    def reset(self) -> None:
        """Prepare for an episode."""
        self.reason = ""
        self._stream = np.random.default_rng(self._seed)
        self._visits, self._loaded = Counter[Cell](), False

    def act(self, observation: Observation) -> str:
        """Return the action for ``observation`` and set ``reason`` to its probability.

        Raises:
            AgentError: the view radius differs from the one in training.
        """
        self._network.check_view(observation, self._name)
        logits = self._network.logits(network_input(encode(observation), self._network.tiles))
        if self.revisit:
            logits = logits - np.float32(self.revisit) * self._visits_after(observation)
        allowed = np.where(useful_now(observation), logits, -np.inf)
        action = int(allowed.argmax())
        likelihoods = np.exp(np.float64(allowed - allowed[action]))
        likelihoods /= likelihoods.sum()
        if self.samples:
            action = int(self._stream.choice(len(ACTIONS), p=likelihoods))
        self.reason = f"{100 * likelihoods[action]:.0f}% sure"
        return ACTIONS[action]

    def _visits_after(self, observation: Observation) -> SingleFloats:
        """Count a visit, and return the visits to the cell to which each action leads, ``[7]``.

        Picking and dropping never count as visits, because they change the robot's goal.
        """
        here, loaded = observation["robot_pos"], observation["has_item"]
        if loaded != self._loaded:
            self._visits, self._loaded = Counter(), loaded
        self._visits[here] += 1
        ends = [moved(here, delta) for delta in (*MOVE_DELTAS.values(), (0, 0))]
        visits = [self._visits[end] for end in ends]
        return np.array([*visits, *[0] * (len(ACTIONS) - len(visits))], np.float32)


def useful_now(observation: Observation) -> tuple[bool, ...]:
    """Return whether each action would have an effect, as far as the observation shows."""
    moves = open_moves(observation["local_grid"])
    stations = {observation["dropoff_pos"]: DROPOFF, observation["pickup_pos"]: PICKUP}
    tile = stations.get(observation["robot_pos"], EMPTY)
    return useful_actions(
        tuple(move in moves for move in MOVE_DELTAS), tile, observation["has_item"]
    )
