"""The utility-based agent: it weighs what a delivery is worth against what it will cost.

Source: Russell and Norvig, 4th ed., section 2.4.5.
"""

from __future__ import annotations

import math
from itertools import pairwise

from agents.kinds.risk_map import Plan, RiskMap
from warehouse_core.arguments import real_number
from warehouse_core.task.rules import CHARGE
from warehouse_core.task.state import Observation

WORTH = 200.0
"""Worth of a delivery, in steps."""

DOUBT = 0.5
"""Steps that a cell which has not been seen is expected to cost beyond one."""


class UtilityBasedAgent:
    """A utility-based agent: of all plans that it knows it follows the one with the most utility.

    A plan is a pickup and a dropoff, and perhaps a charger on the way. Its utility is the worth of
    a delivery, if the battery will last, less the expected steps. To give up has utility 0.

    Args:
        worth: worth of a delivery, in steps.
        doubt: steps that an unseen cell is expected to cost beyond one.

    Example:
        >>> from agents import UtilityBasedAgent
        >>> from warehouse_core import WarehouseEnv, record_episode
        >>> episode = record_episode(WarehouseEnv(battery=10), UtilityBasedAgent(), seed=12)
        >>> episode.actions[0], episode.reasons[0]
        ('WAIT', 'gives up')
    """

    def __init__(self, worth: float = WORTH, doubt: float = DOUBT) -> None:
        self.worth, self.doubt = real_number("worth", worth), real_number("doubt", doubt)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._map, self._full, self.reason = RiskMap(self.doubt), 0, ""

    def act(self, observation: Observation) -> str:
        """Return the first action of the best plan, and set ``reason`` to its utility."""
        self._map.look(observation)
        self._full = max(self._full, observation["battery"])
        plans = self._map.plans(observation["has_item"])
        best = max(plans, key=lambda plan: self._utility(plan, observation), default=())
        utility = self._utility(best, observation)
        self.reason = f"utility {utility:.0f}" if utility > 0 else "gives up"
        return self._map.action_towards(best[0], observation) if utility > 0 else "WAIT"

    def _utility(self, plan: Plan, observation: Observation) -> float:
        battery, steps = float(observation["battery"]), 0.0
        for start, stop in pairwise((observation["robot_pos"], *plan)):
            charges = self._map.is_charger(stop)
            needed = self._map.steps(start, stop) + (not charges)
            if needed > battery:
                return -needed
            waits = math.ceil((self._full - battery + needed) / (CHARGE - 1)) if charges else 0
            battery = self._full if charges else battery - needed
            steps += needed + waits
        return self.worth - steps if plan else 0.0
