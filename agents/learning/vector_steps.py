"""Steps of a batch in the format of Stable-Baselines3, without importing it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.learning.policy_network import TIMES, Floats, network_input
from warehouse_core.task.encoding import vector_limits
from warehouse_core.vector.env import BatchEnv

VectorStep = tuple[Floats, Floats, NDArray[np.bool_], list[dict[str, Any]]]
"""``[B, L]`` observations, ``[B]`` rewards, ``[B]`` whether an episode ended, ``B`` infos."""


def input_limits(batch: BatchEnv) -> tuple[Floats, Floats]:
    """Return the lowest and the highest values of an observation, ``[L]``."""
    limits = vector_limits(*batch.size, batch.view_radius, batch.max_battery, batch.max_steps)
    return limits[0][:-TIMES], limits[1][:-TIMES]


def vector_step(batch: BatchEnv, actions: NDArray[np.int64]) -> VectorStep:
    """Carry out one action in each row of a batch with ``autoreset_mode="SameStep"``.

    The observation of a row that ended is the first of its next episode. Its info has the last one
    of the old episode as ``terminal_observation``; ``TimeLimit.truncated``, true if the value of
    later steps still counts; and ``is_success``.
    """
    arrays, rewards, terminated, truncated, info = batch.step(actions)
    ended = terminated | truncated
    infos: list[dict[str, Any]] = [{} for _ in range(batch.num_envs)]
    if ended.any():
        last = network_input(info["final_obs"])
        for row in np.flatnonzero(ended).tolist():
            delivered = bool(terminated[row])
            infos[row] = {
                "terminal_observation": last[row],
                "TimeLimit.truncated": not delivered,
                "is_success": delivered,
            }
    return network_input(arrays), rewards.astype(np.float32), ended, infos
