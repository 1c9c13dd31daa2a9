"""PPO, proximal policy optimisation, with Stable-Baselines3; needs the extra ``rl``.

Actions without effect are masked, so that they are never tried. Without masks, the penalties for
such actions teach the network to wait before it has ever made a delivery.

Source: Schulman et al., *Proximal Policy Optimization Algorithms*, 2017. Huang and Ontañón, *A
Closer Look at Invalid Action Masking in Policy Gradient Algorithms*, 2022.
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecEnv

from agents.learning.learner import RECENT_EPISODES, MakeAgent, WatchTraining
from agents.learning.map_memory import SingleFloats
from agents.learning.policy_network import Layer, PolicyNetwork, layer_of, network_input
from agents.learning.ppo_agent import PPOAgent
from agents.learning.vector_steps import Batch, VectorStep, input_limits, tiles_of, vector_step
from warehouse_core.files.atomic import atomic_path
from warehouse_core.world.actions import ACTIONS

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
"""Settings tuned on the chapter's layout; all others are the defaults of Stable-Baselines3."""

FOR_RANDOM_LAYOUTS: dict[str, Any] = {"gamma": 0.98, "policy_kwargs": {"net_arch": [128, 128]}}
"""Settings for a new layout in each episode, where paths are longer and the task is harder."""


class RowsVecEnv(VecEnv):
    """A base class of all rows of a ``_batch`` as one ``VecEnv``; they share their attributes."""

    _batch: Any

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the batch, such as ``action_masks``, and return a list of its rows."""
        results = getattr(self._batch, method_name)(*method_args, **method_kwargs)
        return [results[row] for row in self._get_indices(indices)]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the batch for each row; ``render_mode`` is always ``None``."""
        value = None if attr_name == "render_mode" else getattr(self._batch, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raise ``NotImplementedError``: the rows share their attributes."""
        raise NotImplementedError(f"{attr_name} cannot be set; make another batch")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return ``False`` for each row."""
        return [False for _ in self._get_indices(indices)]

    def close(self) -> None:
        """Close the batch."""
        self._batch.close()


class BatchVecEnv(RowsVecEnv):
    """All rows of a batch with ``autoreset_mode="SameStep"`` as one ``VecEnv`` with masks.

    The rows of a ``FleetBatch`` are its robots, which therefore share one policy. See
    ``vector_steps.py`` for observations and infos.
    """

    def __init__(self, batch: Batch) -> None:
        self._batch, self._tiles = batch, tiles_of(batch)
        limits = spaces.Box(*input_limits(batch), dtype=np.float32)
        super().__init__(batch.num_envs, limits, spaces.Discrete(len(ACTIONS)))

    def reset(self) -> SingleFloats:
        """Start an episode in every row, with the seeds given to ``seed``, if any."""
        floors = len(self._batch.layouts.kind)
        arrays, _ = self._batch.reset(self._seeds[:floors])
        self._reset_seeds()
        return network_input(arrays, self._tiles)

    def step_async(self, actions: NDArray[np.int64]) -> None:
        """Store the actions for ``step_wait``."""
        self._actions = actions

    def step_wait(self) -> VectorStep:
        """Carry out the stored actions."""
        return vector_step(self._batch, self._actions)


class PPOLearner:
    """Training of a network with PPO in the episodes of a batch.

    Args:
        batch: environments with ``autoreset_mode="SameStep"``, by default ``ENVS`` rows. The robots
            of a fleet share the network.
        steps: steps of the whole training, rounded up to whole rounds of all rows.
        seed: seed with which a training can be repeated on the same machine with the same versions.
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
            # ``left`` no longer includes the round whose update uses the rate.
            learning_rate=lambda left: LEARNING_RATE * (left + 1 / rounds),
            seed=seed,
            **SETTINGS | settings,
        )
        self.model.set_logger(
            Logger(None, [])
        )  # the default logger leaves a temporary folder behind

    def learn(self, watch: WatchTraining) -> MakeAgent:
        """Train to the end, and return a function that makes the agent."""
        left = self._rounds * self._round - self.model.num_timesteps
        # Without a reset, the counters of a restored training continue.
        self.model.learn(left, callback=_Watcher(self, watch), reset_num_timesteps=False)
        return self.agents()

    def state(self) -> Any:
        """Return the model with its optimiser, the warehouses, and the random streams."""
        model = io.BytesIO()
        self.model.save(model)
        return model.getvalue(), self._batch, torch.get_rng_state(), np.random.get_state()

    def restore(self, state: Any) -> None:
        """Continue from the state of a learner with the same arguments."""
        model, self._batch, of_torch, of_numpy = state
        # A forced reset would begin new episodes.
        self.model = MaskablePPO.load(
            io.BytesIO(model), BatchVecEnv(self._batch), device="cpu", force_reset=False
        )
        self.model.set_logger(Logger(None, []))
        torch.set_rng_state(of_torch)
        np.random.set_state(of_numpy)

    def agents(self) -> MakeAgent:
        """Return a function that makes the current agent; further training does not change it."""
        network = self.network()
        return lambda seed: PPOAgent(network, seed=seed)

    def network(self) -> PolicyNetwork:
        """Return a copy of the policy network."""
        return PolicyNetwork(self._view_radius, layers_in(self.model), self._tiles)

    def save_network(self, path: Path) -> None:
        """Write the file that ``PPOAgent.load`` reads."""
        self.network().save(path)

    def save_model(self, path: Path) -> None:
        """Write the file that ``MaskablePPO.load`` reads, for further training."""
        with atomic_path(path) as part:
            self.model.save(part)


class _Watcher(BaseCallback):
    """Callback that calls ``watch`` before each round and at the end."""

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


def layers_in(model: Any) -> list[Layer]:
    """Return copies of the layers with which the policy of a model chooses actions."""
    policy = model.policy
    hidden = [part for part in policy.mlp_extractor.policy_net if isinstance(part, torch.nn.Linear)]
    return [layer_of(part) for part in (*hidden, policy.action_net)]
