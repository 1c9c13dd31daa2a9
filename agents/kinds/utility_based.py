"""The utility-based agent, which weighs the value of a delivery against its cost.

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
"""Value of a delivery, in steps."""

DOUBT = 0.5
"""Expected number of steps, beyond one, to enter a cell that has not been seen."""


class UtilityBasedAgent:
    """A utility-based agent, which follows the plan with the highest utility.

    A plan is a pickup and a dropoff, and possibly a charger to stop at. If the battery will last
    for a plan, its utility is the value of a delivery minus the expected number of steps. Giving up
    has utility 0.

    Args:
        worth: value of a delivery, in steps.
        doubt: expected number of steps, beyond one, to enter an unseen cell.

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
