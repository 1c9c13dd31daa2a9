"""Four kinds of agents, one file each: reflex, model-based, goal-based and utility-based.

The fifth kind, the learning agent, is in ``agents/learning``. Each class is short, so that readers
can change it.

Source: Russell and Norvig, 4th ed., section 2.4.
"""

from agents.kinds.goal_based import GoalBasedAgent
from agents.kinds.model_based import ModelBasedAgent
from agents.kinds.simple_reflex import ReflexAgent
from agents.kinds.utility_based import UtilityBasedAgent

__all__ = ["GoalBasedAgent", "ModelBasedAgent", "ReflexAgent", "UtilityBasedAgent"]
