"""Agents for the warehouse, their episode runner and the command line.

Agents are imported on first use, so that ``import agents`` is fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from agents.kinds.goal_based import GoalBasedAgent
    from agents.kinds.model_based import ModelBasedAgent
    from agents.kinds.simple_reflex import ReflexAgent
    from agents.kinds.utility_based import UtilityBasedAgent
    from agents.learning.clone_agent import CloneAgent
    from agents.learning.ppo_agent import PPOAgent
    from agents.learning.q_learning import QAgent
    from agents.search.agents import ExploringAgent, SearchAgent
    from agents.warehouse_agent_greedy import GreedyAgent

__all__ = [
    "CloneAgent",
    "ExploringAgent",
    "GoalBasedAgent",
    "GreedyAgent",
    "ModelBasedAgent",
    "PPOAgent",
    "QAgent",
    "ReflexAgent",
    "SearchAgent",
    "UtilityBasedAgent",
]

_MODULES = {
    "CloneAgent": "agents.learning.clone_agent",
    "ExploringAgent": "agents.search.agents",
    "GoalBasedAgent": "agents.kinds.goal_based",
    "GreedyAgent": "agents.warehouse_agent_greedy",
    "ModelBasedAgent": "agents.kinds.model_based",
    "PPOAgent": "agents.learning.ppo_agent",
    "QAgent": "agents.learning.q_learning",
    "ReflexAgent": "agents.kinds.simple_reflex",
    "SearchAgent": "agents.search.agents",
    "UtilityBasedAgent": "agents.kinds.utility_based",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)
