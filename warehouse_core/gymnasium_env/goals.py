"""A warehouse with goals, for learning from failures by hindsight."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from warehouse_core.errors import LayoutError
from warehouse_core.gymnasium_env.env import ENDED, WarehouseGymnasiumEnv
from warehouse_core.gymnasium_env.spaces import MIN_SIDE
from warehouse_core.task.encoding import (
    CELLS_PER_UNIT,
    ObservationArrays,
    vector,
    vector_limits,
)
from warehouse_core.wording import brief
from warehouse_core.world.tiles import PICKUP, WALL

SEEN = (WALL, PICKUP)
"""Tiles that are marked in observations. The dropoff is not, as the goal may be another cell."""

GOAL_NUMBERS = 3
"""Numbers of a goal: row, column, and whether the robot has an item."""

DROPOFF_NUMBERS = [-6, -5, -4]
"""Indices of the dropoff's numbers in a vector."""


class WarehouseGoalEnv(WarehouseGymnasiumEnv):
    """The environment ``WarehouseGoal-v0``, with goals for hindsight experience replay.

    Description:
        A goal is to be in a cell, either with an item or without one. The goal of an episode is to
        be in the cell of the dropoff with the item from the pickup. Otherwise the environment
        equals ``Warehouse-v0``.

    Actions:
        The same as in ``Warehouse-v0``. Achieving the goal takes no ``DROP``.

    Observations:
        ``observation`` is a ``Box``, the form ``"vector"`` without the dropoff. ``achieved_goal``
        is ``[3]`` float32: row and column of the robot, in tens of cells, and 1 if it holds an
        item. ``desired_goal`` has the same numbers of the goal.

    Rewards:
        0 for the step that achieves the goal, and -1 for every other step. ``compute_reward``
        returns the reward for any goals.

    Ends:
        An episode is terminated when the goal is achieved, or when the item is delivered to another
        dropoff. It is truncated like ``Warehouse-v0``.

    Args:
        settings: arguments of ``Warehouse-v0``, except ``observation`` and ``scan``.

    Raises:
        LayoutError: the layout has no pickup or no dropoff, and the stations are not random.
        ValueError: an argument is not allowed.
        TypeError: an argument has the wrong type.

    Source: Andrychowicz et al., Hindsight Experience Replay, 2017.

    Example:
        >>> import gymnasium
        >>> from warehouse_core.gymnasium_env import GOAL_ID
        >>> env = gymnasium.make(GOAL_ID)
        >>> observation, info = env.reset(seed=1)
        >>> {name: values.shape for name, values in observation.items()}
        {'observation': (58,), 'achieved_goal': (3,), 'desired_goal': (3,)}
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(observation="dict", **settings)
        env = self.warehouse
        limits = vector_limits(
            max(env.height, MIN_SIDE), max(env.width, MIN_SIDE), env.view_radius,
            env.max_battery, env.max_steps, SEEN,
        )  # fmt: skip
        low, high = map(_without_dropoff, limits)
        last = np.maximum([env.height, env.width], MIN_SIDE) - 1
        goal = _goal(last * 0, False), _goal(last, True)
        self.observation_space = spaces.Dict(
            {
                "observation": spaces.Box(low, high, dtype=np.float32),
                "achieved_goal": spaces.Box(*goal, dtype=np.float32),
                "desired_goal": spaces.Box(*goal, dtype=np.float32),
            }
        )
        self._form = _with_goals

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode; see ``WarehouseGymnasiumEnv``.

        Raises:
            LayoutError: the layout has no pickup or no dropoff.
        """
        found = super().reset(seed=seed, options=options)
        layout = self.warehouse.layout
        if not (layout.pickups and layout.dropoffs):
            raise LayoutError("the layout has no pickup or no dropoff; goals need both")
        return found

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Carry out one action, an integer 0 to 6; see ``WarehouseGymnasiumEnv``."""
        observation, _, terminated, truncated, info = super().step(action)
        goals = observation["achieved_goal"], observation["desired_goal"]
        reward = float(self.compute_reward(*goals, info))
        if reward == 0.0:
            terminated, self._over = True, ENDED
        return observation, reward, terminated, truncated, info

    def compute_reward(
        self, achieved_goal: ArrayLike, desired_goal: ArrayLike, info: Any
    ) -> NDArray[np.float32]:
        """Return the rewards ``[...]``: 0 for each goal that is achieved, otherwise -1.

        Args:
            achieved_goal: ``[..., 3]`` achieved goals.
            desired_goal: ``[..., 3]`` desired goals.
            info: not used.

        Raises:
            ValueError: the goals have a wrong shape, or different shapes.
            TypeError: the goals are not numbers.
        """
        achieved = _checked("achieved_goal", achieved_goal)
        desired = _checked("desired_goal", desired_goal)
        if achieved.shape != desired.shape:
            raise ValueError(
                f"desired_goal has the shape {desired.shape}; it must have the shape of "
                f"achieved_goal, {achieved.shape}"
            )
        return -np.asarray((achieved != desired).any(axis=-1), np.float32)


def _with_goals(arrays: ObservationArrays) -> dict[str, NDArray[np.float32]]:
    """Return an observation with its goals, given the observation as arrays."""
    return {
        "observation": _without_dropoff(vector(arrays, SEEN)),
        "achieved_goal": _goal(arrays["robot_pos"], arrays["has_item"]),
        "desired_goal": _goal(arrays["dropoff_pos"], True),
    }


def _checked(name: str, goals: ArrayLike) -> NDArray[Any]:
    """Return goals as an array ``[..., 3]``."""
    try:
        given = np.asarray(goals)
    except Exception:  # rows of different lengths, or a user's ``__array__``
        raise TypeError(f"{name} is {brief(goals)}; it must be numbers") from None
    if given.dtype.kind not in "iuf":
        raise TypeError(f"{name} is {given.dtype}; it must be numbers")
    if given.shape[-1:] != (GOAL_NUMBERS,):
        raise ValueError(
            f"{name} has the shape {given.shape}; its last axis must have {GOAL_NUMBERS} numbers"
        )
    return given


def _goal(cell: NDArray[Any], has_item: Any) -> NDArray[np.float32]:
    return np.array([*cell / CELLS_PER_UNIT, has_item], np.float32)


def _without_dropoff(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.delete(values, DROPOFF_NUMBERS)
