"""Interfaces between a learner and the code that monitors its training."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from warehouse_core import Agent

RECENT_EPISODES = 1000
"""Number of episodes over which a learner averages the share of deliveries."""

MakeAgent = Callable[[int], Agent]
"""Function that makes an agent for the episode with a given seed."""

WatchTraining = Callable[[int, float, MakeAgent], None]
"""Callback that monitors a training; a learner calls it regularly and at the end.

Its arguments are the number of steps so far, the share of recent episodes that ended with the
delivery (NaN without any), and a function that makes the current agent.
"""


class Resumable(Protocol):
    """A training that can be stopped at a callback and resumed later with the same result."""

    def state(self) -> Any:
        """Return everything that further training depends on, to be pickled before it continues.

        The state is complete while ``watch`` is called.
        """

    def restore(self, state: Any) -> None:
        """Continue from the state of a learner with the same arguments."""


class Learner(Resumable, Protocol):
    """A training of an agent."""

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train to the end, and return a function that makes the agent."""
