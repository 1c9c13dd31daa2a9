"""A trained network that controls a body: speeds from observations, with NumPy alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from agents.errors import AgentError
from agents.learning.map_memory import SingleFloats
from agents.learning.policy_network import DriveNetwork
from warehouse_core.arguments import instance_of
from warehouse_core.wording import brief


class DrivePolicy:
    """An agent for ``WarehouseDrive-v0`` whose network ``warehouse train drive`` has trained.

    Attributes:
        backend: name of the environment for which it was trained; see ``DriveEnv.from_name``.

    Example:
        >>> import numpy as np
        >>> from agents.learning import DriveNetwork, DrivePolicy
        >>> widths = [29, 8, 8, 2]
        >>> layers = [(np.zeros((b, a)), np.zeros(b)) for a, b in zip(widths, widths[1:])]
        >>> policy = DrivePolicy(DriveNetwork("drive", layers))  # not trained
        >>> policy.act(np.zeros(29))
        array([0., 0.])
    """

    def __init__(self, network: DriveNetwork) -> None:
        self._network = instance_of("network", network, DriveNetwork)
        self.backend = network.backend

    @classmethod
    def load(cls, path: Path) -> DrivePolicy:
        """Return the agent with the network in a file.

        Raises:
            RecordError: the file is damaged or has other contents.
            OSError: the file cannot be read.
        """
        return cls(DriveNetwork.load(path))

    def reset(self) -> None:
        """Do nothing: the policy has no memory."""

    def act(self, observation: Any) -> SingleFloats:
        """Return the action for an observation in the form ``"vector"``.

        Raises:
            AgentError: the observation has another form or length.
        """
        needed = self._network.inputs
        if not isinstance(observation, np.ndarray) or observation.shape != (needed,):
            raise AgentError(
                f"the observation is {brief(observation)}; this agent controls a body and needs "
                f"{needed} numbers, as with --backend drive"
            )
        return self._network.commands(observation)
