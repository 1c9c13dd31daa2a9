"""Helpers for tests of ``Warehouse-v0``: make it, step it, compare results."""

from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import SyncVectorEnv

from warehouse_core import Layout
from warehouse_core.gymnasium_env import ID, WarehouseGymnasiumEnv

NAME = f"warehouse_core.gymnasium_env:{ID}"
"""Name of the environment for a program that imports only Gymnasium."""

ROOM = Layout(["#####", "#P.D#", "#...#", "#####"])
CORRIDOR = Layout(["P....D"])

HAS_MODES = hasattr(gymnasium.vector, "AutoresetMode")
MODES = ["NextStep", "SameStep", "Disabled"] if HAS_MODES else ["NextStep"]


def make(**settings: Any) -> Any:
    return gymnasium.make(NAME, **settings)


def plain(**settings: Any) -> WarehouseGymnasiumEnv:
    return make(**settings).unwrapped


def make_vec(count: int, mode: str, **settings: Any) -> Any:
    return gymnasium.make_vec(NAME, count, "vector_entry_point", autoreset_mode=mode, **settings)


def make_sync(count: int, mode: str, **settings: Any) -> SyncVectorEnv:
    modes = {"autoreset_mode": mode} if HAS_MODES else {}
    return SyncVectorEnv([partial(make, **settings)] * count, **modes)


def same(value: Any, other: Any) -> bool:
    """Return whether two observations or parts of info are equal, with the dtypes of arrays."""
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(same(value[key], other[key]) for key in value)
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return len(value) == len(other) and all(map(same, value, other))
    if isinstance(value, np.ndarray):
        return value.dtype == other.dtype and np.array_equal(value, other)
    return type(value) is type(other) and bool(value == other)


def walk(env: Any, seed: int, steps: int = 40) -> list[Any]:
    """Return all results of a random walk that restarts after each end."""
    stream = np.random.default_rng(seed)
    results: list[Any] = [env.reset(seed=seed)]
    for action in stream.integers(7, size=steps).tolist():
        results.append(env.step(action))
        if results[-1][2] or results[-1][3]:
            results.append(env.reset())
    return results
