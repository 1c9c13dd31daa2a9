"""Agents that learn, and their training.

Training by PPO, ``agents.learning.ppo_training``, and by imitation,
``agents.learning.clone_training``, needs the extra ``rl``.
"""

from agents.learning.clone_agent import CloneAgent
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_learning import QAgent, QTable
from agents.learning.q_table import load_agent, load_table, save_table

__all__ = ["CloneAgent", "PPOAgent", "QAgent", "QTable", "load_agent", "load_table", "save_table"]
