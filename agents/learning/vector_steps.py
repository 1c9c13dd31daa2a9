"""Steps of a batch in the format of Stable-Baselines3, without importing it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.learning.map_memory import SingleFloats
from agents.learning.policy_network import TIMES, Tiles, network_input
from warehouse_core.batch import BatchEnv
from warehouse_core.batch.fleets import FleetBatch
from warehouse_core.task.encoding import FLEET_TILES, MARKED_TILES, vector_limits

VectorStep = tuple[SingleFloats, SingleFloats, NDArray[np.bool_], list[dict[str, Any]]]
"""``[B, L]`` observations, ``[B]`` rewards, ``[B]`` ends of episodes, and ``B`` infos."""

Batch = BatchEnv | FleetBatch
"""A batch whose rows are warehouses, or the robots of fleets."""


def tiles_of(batch: Batch) -> Tiles:
    """Return the tiles that a network for the rows of a batch distinguishes."""
    return FLEET_TILES if isinstance(batch, FleetBatch) else MARKED_TILES


def input_limits(batch: Batch) -> tuple[SingleFloats, SingleFloats]:
    """Return the lowest and the highest values of an observation, ``[L]``."""
    budgets = batch.max_battery, batch.max_steps
    limits = vector_limits(*batch.size, batch.view_radius, *budgets, tiles_of(batch))
    return limits[0][:-TIMES], limits[1][:-TIMES]


def vector_step(batch: Batch, actions: NDArray[np.int64]) -> VectorStep:
    """Carry out one action in each row of a batch with ``autoreset_mode="SameStep"``.

    If the episode of a row has ended, its observation is the first of the next episode. Its info
    then has three entries: ``terminal_observation`` is the last observation of the old episode.
    ``TimeLimit.truncated`` is true if the value of later steps still counts. ``is_success`` is true
    if the episode ended with the delivery; fleets do not have it.
    """
    arrays, rewards, terminated, truncated, info = batch.step(actions)
    ended, tiles = terminated | truncated, tiles_of(batch)
    infos: list[dict[str, Any]] = [{} for _ in range(batch.num_envs)]
    if "final_obs" in info:
        last = network_input(info["final_obs"], tiles)
        ended &= info["_final_obs"]
        for row in np.flatnonzero(ended).tolist():
            delivered = bool(terminated[row])
            infos[row] = {
                "terminal_observation": last[row],
                "TimeLimit.truncated": not delivered,
            }
            if isinstance(batch, BatchEnv):  # a fleet with a stream of orders is never done
                infos[row]["is_success"] = delivered
    return network_input(arrays, tiles), rewards.astype(np.float32), ended, infos
