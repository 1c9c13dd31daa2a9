"""Agents that learn, and their training.

Training with PPO (``agents.learning.ppo_training``) and training by imitation
(``agents.learning.clone_training``) need the extra ``rl``. So does training of continuous control
(``agents.learning.drive_training``).
"""

from agents.learning.clone_agent import CloneAgent
from agents.learning.drive_policy import DrivePolicy
from agents.learning.policy_network import DriveNetwork
from agents.learning.ppo_agent import PPOAgent
from agents.learning.q_learning import QAgent, QTable
from agents.learning.q_table import load_agent, load_table, save_table

__all__ = [
    "CloneAgent",
    "DriveNetwork",
    "DrivePolicy",
    "PPOAgent",
    "QAgent",
    "QTable",
    "load_agent",
    "load_table",
    "save_table",
]
