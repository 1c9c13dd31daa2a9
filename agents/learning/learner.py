"""What a learner gives to the one who watches its training."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from warehouse_core import Agent

RECENT_EPISODES = 1000
"""Episodes over which a learner averages the share of deliveries."""

MakeAgent = Callable[[int], Agent]
"""Makes the agent of the episode with a seed."""

WatchTraining = Callable[[int, float, MakeAgent], None]
"""Watches a training: a learner calls it regularly and at its end.

It is given the steps taken so far, the share of the latest episodes that ended with the delivery
(NaN without any), and what makes the agent in its present state.
"""


class Resumable(Protocol):
    """A training that can be stopped while it is watched, and resumed later to the same result."""

    def state(self) -> Any:
        """Return all that further training depends on, to be pickled before the training goes on.

        It is whole while ``watch`` is called.
        """

    def restore(self, state: Any) -> None:
        """Go on from a state that a learner with the same arguments had."""


class Learner(Resumable, Protocol):
    """A training of an agent."""

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train to the end, and return what makes the agent."""
