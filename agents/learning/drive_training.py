"""Training of continuous control with PPO from Stable-Baselines3; needs the extra ``rl``.

Deliveries are too rare to learn from by chance. So the reward is shaped by a potential: the length
of the shortest path to the delivery, and the time for which the robot has stood at a station. Such
a potential does not change which policy is best. In the first parts of a training, picking and
dropping take less time than in the task, so that robots find out what they are for. Observations
are scaled to mean 0 and variance 1; the network that is saved does this in its first layer.

Source: Ng, Harada and Russell (1999), *Policy Invariance Under Reward Transformations*.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecNormalize

from agents.learning.policy_network import DriveNetwork
from agents.learning.ppo_training import RowsVecEnv, layers_in
from warehouse_core import Layout
from warehouse_core.world.distances import distances
from warehouse_core.world.tiles import MOVE_DELTAS, WALL
from warehouse_physics import RobotSpec
from warehouse_physics.drive import DriveVectorEnv

ARGUMENTS: dict[str, Any] = {"rate": 5.0, "rays": 8, "max_seconds": 60.0}
"""Arguments of the environment for which a network is trained, except for the robot."""

BACKEND = ",".join(["drive:drive=omnidirectional", *(f"{k}={v}" for k, v in ARGUMENTS.items())])
"""Name of this environment."""

ENVS, ROUND = 128, 128
"""Rows of the batch, and steps of each row between two updates of the network."""

PARTS = ((0.2, 0.07), (0.4, 0.05), (0.6, 0.05), (0.8, 0.05), (1.0, 0.78))
"""Seconds that picking and dropping take in each part of a training, and share of its steps."""

LEARNING_RATE, LAST_RATE = 1e-3, 1e-5
"""Learning rate of all parts but the last, in which it decreases linearly."""

SETTINGS: dict[str, Any] = {
    "n_steps": ROUND,
    "batch_size": 2048,
    "n_epochs": 5,
    "gamma": 0.99,
    "policy_kwargs": {"net_arch": [128, 128], "log_std_init": -0.5},
    "device": "cpu",
}
"""Settings tuned on the chapter's layout; all others are the defaults of Stable-Baselines3."""

STANDING_WORTH = 3.0
"""Cells that a second of standing at a station is worth."""

CARRYING = 12.0
"""Cells that are added to the distance of a robot without an item."""

WatchDrive = Callable[[int, float], None]
"""Callback with the steps so far, and the share of the latest episodes that were delivered."""


class ShapedRows(RowsVecEnv):
    """The rows of continuous control as a ``VecEnv`` with shaped rewards."""

    def __init__(self, layout: Layout, dwell: float, seed: int) -> None:
        spec = RobotSpec(dwell=dwell)
        self._batch = DriveVectorEnv(
            ENVS, layout, spec=spec, autoreset_mode="SameStep", **ARGUMENTS
        )
        self._seed, self._distances = seed, all_distances(layout)
        self._is_open = np.array([list(row) for row in layout.rows]) != WALL
        self.delivered: list[bool] = []
        size = self._batch.single_observation_space.shape
        # The bounds of ``stood`` depend on ``dwell``, but the network stays the same.
        super().__init__(
            ENVS, spaces.Box(-np.inf, np.inf, size, np.float32), self._batch.single_action_space
        )

    def potentials(self) -> NDArray[np.float64]:
        """Return how far each row has come, ``[B]``: minus the cells to the delivery."""
        rows, width = self._batch.rows, self._is_open.shape[1]
        cells, places = rows.cells(), rows.state.positions
        goals = np.floor(rows.goals()[:, ::-1]).astype(np.intp)
        fields = self._distances[goals[:, 0] * width + goals[:, 1]]
        best = np.full(ENVS, np.inf)
        for delta in ((0, 0), *MOVE_DELTAS.values()):
            there = cells + delta
            off = np.abs(places - there[:, ::-1] - 0.5).sum(axis=1)
            lengths = fields[np.arange(ENVS), there[:, 0] * width + there[:, 1]] + off
            best = np.minimum(best, np.where(self._is_open[tuple(there.T)], lengths, np.inf))
        is_there = (cells == goals).all(axis=1)
        # At a goal, it only matters that the robot stands.
        best = np.where(is_there, np.hypot(*rows.state.velocities.T) / 2, best)
        ahead = np.where(rows.has_item, 0.0, CARRYING)
        potentials: NDArray[np.float64] = STANDING_WORTH * rows.stood - best - ahead
        return potentials

    def reset(self) -> Any:
        """Start an episode in every row."""
        observations, _ = self._batch.reset(seed=self._seed)
        self._before = self.potentials()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions for ``step_wait``."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Carry out the stored actions."""
        observations, rewards, terminated, truncated, info = self._batch.step(self._actions)
        done, after = terminated | truncated, self.potentials()
        shaped = rewards + np.where(done, 0.0, after - self._before)
        self._before = after
        infos: list[dict[str, Any]] = [{} for _ in range(ENVS)]
        for row in np.flatnonzero(done).tolist():
            self.delivered.append(bool(terminated[row]))
            infos[row] = {
                "terminal_observation": info["final_obs"][row],
                "TimeLimit.truncated": bool(truncated[row] and not terminated[row]),
            }
        return observations, shaped.astype(np.float32), done, infos


class DriveLearner:
    """Training of a network that controls a disc in one layout.

    Args:
        layout: layout, whose stations and starts are random.
        steps: control steps of the whole training.
        seed: seed with which a training can be repeated on the same machine with the same versions.

    Example:
        >>> from agents.learning.drive_training import DriveLearner  # doctest: +SKIP
        >>> from warehouse_core import DEFAULT_LAYOUT
        >>> learner = DriveLearner(DEFAULT_LAYOUT, 100_000, 1)  # doctest: +SKIP
    """

    def __init__(self, layout: Layout, steps: int, seed: int) -> None:
        torch.set_num_threads(1)  # the network is small, and sums are repeatable
        self._layout, self._steps, self._seed = layout, steps, seed
        self._scaled: VecNormalize | None = None
        self._make(0)
        self.model = PPO(
            "MlpPolicy", self._scaled, learning_rate=LEARNING_RATE, seed=seed, **SETTINGS
        )
        self.model.set_logger(Logger(None, []))  # the default one leaves a folder behind

    def learn(self, watch: WatchDrive) -> None:
        """Train to the end."""
        done = 0
        for part, (_, share) in enumerate(PARTS):
            self._make(part)
            self.model.set_env(self._scaled)
            if part == len(PARTS) - 1:
                self.model.learning_rate = lambda left: LEARNING_RATE * left + LAST_RATE
                self.model._setup_lr_schedule()
            self.model.learn(math.ceil(share * self._steps), callback=_EachRound(self, watch, done))
            done += self.model.num_timesteps

    def network(self) -> DriveNetwork:
        """Return a copy of the network, whose first layer takes observations as they are."""
        assert self._scaled is not None
        (weights, biases), *others = layers_in(self.model)
        scale = np.sqrt(self._scaled.obs_rms.var + self._scaled.epsilon)
        weights = weights / scale
        first = weights, biases - weights @ self._scaled.obs_rms.mean
        return DriveNetwork(BACKEND, [first, *others])

    def save(self, path: Path) -> None:
        """Write the file that ``DrivePolicy.load`` reads."""
        self.network().save(path)

    def _make(self, part: int) -> None:
        dwell = PARTS[part][0]
        self.rows = ShapedRows(self._layout, dwell, (self._seed * len(PARTS) + part) * ENVS)
        # The network learns from observations with mean 0 and variance 1, in all parts the same.
        scaled, before = VecNormalize(self.rows, norm_reward=False), self._scaled
        if before is not None:
            scaled.obs_rms = before.obs_rms
        self._scaled = scaled


class _EachRound(BaseCallback):
    """Callback that calls ``watch`` after each round."""

    def __init__(self, learner: DriveLearner, watch: WatchDrive, before: int) -> None:
        super().__init__()
        self._learner, self._watch, self._before = learner, watch, before

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        recent = self._learner.rows.delivered[-1000:]
        share = float(np.mean(recent)) if recent else math.nan
        self._watch(self._before + self.num_timesteps, share)


def all_distances(layout: Layout) -> NDArray[np.float64]:
    """Return the length of the shortest path between each two cells, in cells.

    Returns:
        ``[C, C]`` for the numbers of ``C`` cells; infinite without a path.
    """
    numbers = layout.height * layout.width
    found = np.full((numbers, numbers), np.inf)
    for cell in layout.cells(layout.open_cells):
        found[layout.number(cell)] = distances(layout, [cell]).ravel()
    return found


def exam(
    network: DriveNetwork, layout: Layout, episodes: int, first: int
) -> dict[str, NDArray[Any]]:
    """Return what a network does in the episodes with the seeds from ``first`` on.

    Returns:
        ``delivered``, ``seconds``, ``joules`` and the ``impulse`` of all hits, each ``[episodes]``.
    """
    env = DriveVectorEnv(episodes, layout, spec=RobotSpec(), autoreset_mode="SameStep", **ARGUMENTS)
    observations, _ = env.reset(seed=first)
    runs, result = (
        np.ones(episodes, np.bool_),
        {name: np.zeros(episodes) for name in ("delivered", "seconds", "joules", "impulse")},
    )
    while runs.any():
        observations, _, terminated, truncated, info = env.step(network.commands(observations))
        result["delivered"] += terminated & runs
        result["seconds"] += runs / ARGUMENTS["rate"]
        for name in ("joules", "impulse"):
            result[name] += info[name] * runs
        runs &= ~(terminated | truncated)
    return result
