"""Proximal policy optimisation of a network, by Stable-Baselines3; needs the extra ``rl``.

Actions without effect are masked: they are never tried. Without masks the network learns from their
penalties to wait, before it has ever delivered anything.

Source: Schulman et al., *Proximal Policy Optimization Algorithms*, 2017; Huang and Ontañón, *A
Closer Look at Invalid Action Masking in Policy Gradient Algorithms*, 2022.
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import torch
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger

from agents.learning.learner import RECENT_EPISODES, MakeAgent, WatchTraining
from agents.learning.policy_network import Layer, PolicyNetwork
from agents.learning.ppo_agent import PPOAgent
from agents.learning.vec_env import BatchVecEnv
from agents.learning.vector_steps import Batch, tiles_of
from warehouse_core.files.atomic import atomic_path

ENVS = 128
"""Rows of the batch: warehouses, or robots of fleets."""

ROUND = 64
"""Steps of each row between two updates of the network."""

LEARNING_RATE = 2e-3
"""Learning rate of the first round; it decreases linearly, to 0 after the last round."""

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
"""Chosen on the chapter's layout; all others are the defaults of Stable-Baselines3."""

FOR_RANDOM_LAYOUTS: dict[str, Any] = {"gamma": 0.98, "policy_kwargs": {"net_arch": [128, 128]}}
"""Settings for another layout in each episode: ways are longer, and there is more to learn."""


class PPOLearner:
    """Learns from the episodes of a batch.

    Args:
        batch: environments with ``autoreset_mode="SameStep"``, usually ``ENVS`` rows. The robots of
            a fleet share the network.
        steps: steps of the whole training, rounded up to whole rounds of all rows.
        seed: seed that repeats a training on the same machine with the same versions.
        settings: settings that differ from ``SETTINGS``, such as ``FOR_RANDOM_LAYOUTS``.

    Example:
        >>> from agents.learning.ppo_training import PPOLearner  # doctest: +SKIP
        >>> from warehouse_core import BatchEnv
        >>> batch = BatchEnv(64, autoreset_mode="SameStep")
        >>> learner = PPOLearner(batch, steps=100_000, seed=1)  # doctest: +SKIP
    """

    def __init__(self, batch: Batch, steps: int, seed: int, **settings: Any) -> None:
        torch.set_num_threads(1)  # the network is small, and sums are repeatable
        self._view_radius, self._tiles = batch.view_radius, tiles_of(batch)
        self._batch = batch
        self._round = batch.num_envs * ROUND
        self._rounds = rounds = math.ceil(steps / self._round)
        self.model = MaskablePPO(
            "MlpPolicy",
            BatchVecEnv(batch),
            # ``left`` has been reduced by the round whose update uses the rate.
            learning_rate=lambda left: LEARNING_RATE * (left + 1 / rounds),
            seed=seed,
            **SETTINGS | settings,
        )
        self.model.set_logger(Logger(None, []))  # its own makes a temporary folder, and keeps it

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train, and return what makes the agent."""
        left = self._rounds * self._round - self.model.num_timesteps
        # Without a reset the counters go on where a restored training had stopped.
        self.model.learn(left, callback=_Watcher(self, watch), reset_num_timesteps=False)
        return self.agents()

    def state(self) -> Any:
        """Return the model with its optimiser, the warehouses, and the random streams."""
        model = io.BytesIO()
        self.model.save(model)
        return model.getvalue(), self._batch, torch.get_rng_state(), np.random.get_state()

    def restore(self, state: Any) -> None:
        """Go on from a state that a learner with the same arguments had."""
        model, self._batch, of_torch, of_numpy = state
        # A forced reset would begin new episodes.
        self.model = MaskablePPO.load(
            io.BytesIO(model), BatchVecEnv(self._batch), device="cpu", force_reset=False
        )
        self.model.set_logger(Logger(None, []))
        torch.set_rng_state(of_torch)
        np.random.set_state(of_numpy)

    def agents(self) -> MakeAgent:
        """Return what makes the agent in its present state; further training does not change it."""
        network = self.network()
        return lambda seed: PPOAgent(network, seed=seed)

    def network(self) -> PolicyNetwork:
        """Return a copy of the policy network."""
        policy = self.model.policy
        hidden = [
            part for part in policy.mlp_extractor.policy_net if isinstance(part, torch.nn.Linear)
        ]
        layers = [_copy(part) for part in (*hidden, policy.action_net)]
        return PolicyNetwork(self._view_radius, layers, self._tiles)

    def save_network(self, path: Path) -> None:
        """Write the file that ``PPOAgent.load`` reads."""
        self.network().save(path)

    def save_model(self, path: Path) -> None:
        """Write the file that ``MaskablePPO.load`` reads, for further training."""
        with atomic_path(path) as part:
            self.model.save(part)


class _Watcher(BaseCallback):
    """Calls ``watch`` before each round and at the end."""

    def __init__(self, learner: PPOLearner, watch: WatchTraining) -> None:
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
