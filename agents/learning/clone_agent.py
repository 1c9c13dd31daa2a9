"""The agent that ``warehouse train clone`` trains; running it needs only NumPy.

It uses only its observations, which it remembers.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from agents.learning.map_memory import MapMemory
from agents.learning.policy_network import MoveNetwork
from agents.warehouse_agent_greedy import goal_of
from warehouse_core.arguments import instance_of
from warehouse_core.task.encoding import ObservationArrays, encode
from warehouse_core.task.state import Observation
from warehouse_core.world.tiles import MOVE_DELTAS

WORDS = tuple(MOVE_DELTAS)


class CloneAgent:
    """An agent that takes the move its network ranks highest, apart from moves into walls.

    At its goal it picks or drops. It has a ``MapMemory`` of its own, which each reset clears.

    Args:
        network: network that ranks the moves.
        name: name of the network in error messages.

    Raises:
        TypeError: ``network`` is not a ``MoveNetwork``.

    Example:
        >>> import numpy as np
        >>> from agents import CloneAgent
        >>> from agents.learning.map_memory import view_size
        >>> from agents.learning.policy_network import MoveNetwork
        >>> from warehouse_core import WarehouseEnv
        >>> widths = [view_size(radius=3), 8, 8, 1]
        >>> layers = [(np.zeros((b, a)), np.zeros(b)) for a, b in zip(widths, widths[1:])]
        >>> CloneAgent(MoveNetwork(2, 3, layers)).act(WarehouseEnv().reset())  # not trained
        'E'
    """

    def __init__(self, network: MoveNetwork, name: str = "the network") -> None:
        self._network = instance_of("network", network, MoveNetwork)
        self._name = instance_of("name", name, str)
        self.reset()

    @classmethod
    def load(cls, path: Path) -> CloneAgent:
        """Return an agent with a network from a file.

        Raises:
            RecordError: the file does not contain such a network.
            OSError: the file cannot be read.
        """
        return cls(MoveNetwork.load(path), str(path))

    def reset(self) -> None:
        """Forget everything."""
        self.reason = ""
        self._memory = MapMemory(1, self._network.view_radius, self._network.radius)

    def act(self, observation: Observation) -> str:
        """Return the action for ``observation`` and set ``reason`` to its probability.

        Raises:
            AgentError: the view radius differs from the one in training.
        """
        self._network.check_view(observation, self._name)
        [scores] = self._network.scores(self._memory.look(_batch_of(encode(observation))))
        goal, [is_open] = goal_of(observation), self._memory.is_open
        if goal == observation["robot_pos"]:
            self.reason = "at the goal"
            return "DROP" if observation["has_item"] else "PICK"
        if goal is None or not is_open.any():
            self.reason = "nowhere to go"
            return "WAIT"
        scores = np.where(is_open, scores, -np.inf)
        likelihoods = np.exp(np.float64(scores - scores.max()))
        move = int(scores.argmax())
        self.reason = f"{100 * likelihoods[move] / likelihoods.sum():.0f}% sure"
        return WORDS[move]


def _batch_of(arrays: ObservationArrays) -> ObservationArrays:
    """Return the arrays as a batch with one row."""
    batch: ObservationArrays = {name: np.asarray(each)[None] for name, each in arrays.items()}  # type: ignore[assignment]
    return batch
