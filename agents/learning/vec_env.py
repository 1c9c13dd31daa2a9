"""A batch as a ``VecEnv`` of Stable-Baselines3, with masks; needs the extra ``rl``."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from agents.learning.map_memory import SingleFloats
from agents.learning.policy_network import network_input
from agents.learning.vector_steps import Batch, VectorStep, input_limits, tiles_of, vector_step
from warehouse_core.world.actions import ACTIONS


class BatchVecEnv(VecEnv):
    """All rows of a batch with ``autoreset_mode="SameStep"`` as one ``VecEnv``.

    The rows of a ``FleetBatch`` are its robots, which so share one policy. Observations and infos
    are described in ``vector_steps.py``.
    """

    def __init__(self, batch: Batch) -> None:
        self._batch, self._tiles = batch, tiles_of(batch)
        limits = spaces.Box(*input_limits(batch), dtype=np.float32)
        super().__init__(batch.num_envs, limits, spaces.Discrete(len(ACTIONS)))

    def reset(self) -> SingleFloats:
        """Start an episode in every row, with the seeds given to ``seed`` if there are any."""
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
        """Close the motion backend."""
        self._batch.close()
