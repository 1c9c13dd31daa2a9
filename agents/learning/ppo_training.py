"""Proximal policy optimisation of a network, by Stable-Baselines3; needs the extra ``rl``.

Actions that do nothing are masked: they are never tried. Without masks the penalties for them
teach the network to wait before it has ever delivered anything.

Source: Schulman et al., *Proximal Policy Optimization Algorithms*, 2017; Huang and Ontañón, *A
Closer Look at Invalid Action Masking in Policy Gradient Algorithms*, 2022.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import torch
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback

from agents.evaluation.scores import MakeAgent, Task
from agents.learning.policy_network import Layer, PolicyNetwork
from agents.learning.ppo_agent import PPOAgent
from agents.learning.training import RECENT_EPISODES, Watch
from agents.learning.vec_env import BatchVecEnv
from warehouse_core.files.atomic import atomic_path
from warehouse_core.vector.env import SAME_STEP, BatchEnv

ENVS = 128
"""Warehouses that are stepped together."""

ROUND = 64
"""Steps of each warehouse between two changes of the network."""

LEARNING_RATE = 2e-3
"""Of the first round; it falls in a straight line, and after the last it would be 0."""

SETTINGS: dict[str, Any] = {
    "n_steps": ROUND,
    "batch_size": 2048,
    "n_epochs": 4,
    "gamma": 0.97,
    "ent_coef": 0.02,
    "stats_window_size": RECENT_EPISODES,
    "policy_kwargs": {"net_arch": [64, 64]},
    "device": "cpu",
}
"""Chosen on the chapter's layout; the rest is as Stable-Baselines3 has it."""


class PPOLearner:
    """Learns a task from episodes with random starts.

    Args:
        task: to be learnt.
        steps: of the whole training, rounded up to whole rounds of all warehouses.
        seed: repeats a training, on the same machine and with the same versions.

    Raises:
        LayoutError: the layout has no room for pickup and dropoff.
    """

    def __init__(self, task: Task, steps: int, seed: int) -> None:
        torch.set_num_threads(1)  # the network is small, and sums in one order repeat
        batch = BatchEnv(
            ENVS,
            task.layout,
            max_steps=task.max_steps,
            battery=task.battery,
            autoreset_mode=SAME_STEP,
        )
        self._view_radius = batch.view_radius
        self._rounds = rounds = math.ceil(steps / (ENVS * ROUND))
        self.model = MaskablePPO(
            "MlpPolicy",
            BatchVecEnv(batch),
            # What is left is told after a round, before the network changes by it.
            learning_rate=lambda left: LEARNING_RATE * (left + 1 / rounds),
            seed=seed,
            **SETTINGS,
        )

    def learn(self, watch: Watch) -> MakeAgent:
        """Train, and return what makes the agent."""
        self.model.learn(self._rounds * ENVS * ROUND, callback=_Watcher(self, watch))
        return self.agents()

    def agents(self) -> MakeAgent:
        """Return what makes the agent as it is now; it does not change when training goes on."""
        agent = PPOAgent(self.network())
        return lambda _: agent

    def network(self) -> PolicyNetwork:
        """Return a copy of the network that chooses actions."""
        policy = self.model.policy
        hidden = [part for part in policy.mlp_extractor.policy_net if hasattr(part, "weight")]
        return PolicyNetwork(
            self._view_radius, [_copy(part) for part in (*hidden, policy.action_net)]
        )

    def save_network(self, path: Path) -> None:
        """Write what ``PPOAgent.load`` reads."""
        self.network().save(path)

    def save_model(self, path: Path) -> None:
        """Write what ``MaskablePPO.load`` reads, to train on; load only files that you trust."""
        with atomic_path(path) as part:
            self.model.save(part)


class _Watcher(BaseCallback):
    """Tells of the learner before each round of episodes and at the end."""

    def __init__(self, learner: PPOLearner, watch: Watch) -> None:
        super().__init__()
        self._learner, self._watch = learner, watch

    def _on_rollout_start(self) -> None:
        recent = self.model.ep_success_buffer
        delivers = float(np.mean(recent)) if recent else math.nan
        self._watch(self.num_timesteps, delivers, self._learner.agents())

    def _on_training_end(self) -> None:
        self._on_rollout_start()

    def _on_step(self) -> bool:
        return True


def _copy(part: Any) -> Layer:
    return part.weight.detach().numpy().copy(), part.bias.detach().numpy().copy()
