"""Environments in arrays: how episodes side by side are reset, stepped and restarted.

A *row* is a robot. The engine knows what happens in a step; the shell, which is the same for lone
robots and for fleets, knows when episodes start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import one_of
from warehouse_core.batch.shell.checks import Seeds, checked_actions, checked_mask, checked_seeds
from warehouse_core.batch.shell.floor import ALL
from warehouse_core.copies import CopiedWhole
from warehouse_core.errors import EndedError
from warehouse_core.motion.base import BatchOutcome
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.tables import Flags, Integers, LayoutSet, Rows

NEXT_STEP, SAME_STEP, DISABLED = "NextStep", "SameStep", "Disabled"
AUTORESET_MODES = (NEXT_STEP, SAME_STEP, DISABLED)
"""Modes in which a batch may begin new episodes; named as in Gymnasium."""

NO_FLOORS = np.empty(0, np.intp)

Observed = TypeVar("Observed", bound=ObservationArrays, covariant=True)


class EngineStep(NamedTuple):
    """One step of ``N`` rows, as arrays ``[N]`` that belong to the caller."""

    outcome: BatchOutcome
    rewards: NDArray[np.float64]
    terminated: Flags
    truncated: Flags


class Engine(Protocol[Observed]):
    """``B`` floors with an episode on each, and as many rows on each; ``N`` rows in all."""

    layouts: LayoutSet

    @property
    def ended(self) -> Flags:
        """``[N]``, whether the robot has ended: it waits, stays in the way, and has no reward."""

    def begin(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on different floors; one without a seed continues its random stream."""

    def step(self, actions: NDArray[np.intp], over: Integers = NO_FLOORS) -> EngineStep:
        """Carry out one action, 0 to 6, for each robot; the array may be changed.

        On the floors that are ``over`` the step takes no action, but starts an episode.
        """

    def observe(self, rows: Rows = ALL) -> Observed:
        """Return fresh arrays of what some of the robots observe."""

    def masks(self) -> NDArray[np.int8]:
        """Return ``[N, 7]`` int8: 1 for each action that does something now."""

    def close(self) -> None:
        """Close the motion backend."""


class ArrayEnv(CopiedWhole, Generic[Observed]):
    """``B`` episodes of ``R`` robots each; row ``b * R + r`` is robot ``r`` of episode ``b``.

    Attributes:
        num_envs: number of rows, ``B * R``.
        layouts: layouts of the episodes.
    """

    def __init__(
        self,
        engine: Engine[Observed],
        episodes: int,
        robots: int,
        autoreset_mode: str,
        actions: int = len(ACTIONS),
    ) -> None:
        self.autoreset_mode = one_of("autoreset_mode", autoreset_mode, AUTORESET_MODES)
        self.num_envs = episodes * robots
        self.layouts = engine.layouts
        self._engine, self._episodes, self._robots = engine, episodes, robots
        self._started, self._actions = False, actions

    @property
    def size(self) -> tuple[int, int]:
        """The largest numbers of rows and of columns of any layout."""
        kinds = self.layouts.kinds
        return max(kind.height for kind in kinds), max(kind.width for kind in kinds)

    def reset(
        self, seed: Seeds = None, mask: Flags | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Start all episodes, or the ones that a mask marks.

        Args:
            seed: episode ``b`` draws from ``seed + b``, or from the ``b``-th of ``B`` seeds;
                without one its random numbers continue.
            mask: ``[B]`` bool, the episodes to reset; the others do not change.

        Returns:
            The observation of all rows, and info with the ``action_mask`` of those reset.

        Raises:
            ValueError: a negative seed, or not ``B`` seeds or flags; nothing has changed.
            TypeError: a seed or a flag of another type.
            EndedError: a mask before the first reset.
        """
        seeds = checked_seeds(seed, self._episodes)
        chosen = checked_mask(mask, self._episodes, not self._started)
        episodes = np.flatnonzero(chosen)
        self._engine.begin(episodes, [seeds[episode] for episode in episodes.tolist()])
        self._started = True
        info = {"action_mask": self._engine.masks(), "_action_mask": self._rows_of(chosen)}
        return self._engine.observe(), info

    def step(
        self, actions: ArrayLike
    ) -> tuple[Observed, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """Carry out one action for each robot.

        Args:
            actions: ``[N]`` integers, 0 to 6, or indices of other actions of fleets.

        Returns:
            Observation, ``[N]`` float64 rewards, ``[N]`` bool terminated and truncated, and info,
            with ``action_mask`` ``[N, 7]`` int8; ``motion``, which has ``blocked``, ``seconds`` and
            ``joules``; and, in the same-step mode if episodes have ended, their ``final_obs`` and
            ``final_info``. Each key ``k`` has a key ``_k``, ``[N]`` bool: the rows that it applies
            to, also within ``motion``. All arrays are fresh.

        Raises:
            ValueError: a wrong shape, or an action out of range; nothing has changed.
            TypeError: actions that are not integers.
            EndedError: before a reset, or if episodes have ended in the disabled mode.
        """
        self._check_started("step")
        chosen = checked_actions(actions, self.num_envs, self._actions)
        engine, ended = self._engine, self._ended()
        if self.autoreset_mode == DISABLED:
            _check_running(ended)
        over, fresh = np.flatnonzero(ended), self._rows_of(ended)
        outcome, rewards, terminated, truncated = engine.step(chosen, over)
        if over.size:
            terminated[fresh] = truncated[fresh] = outcome.blocked[fresh] = False
            outcome.seconds[fresh] = outcome.joules[fresh] = 0.0
        motion = {name: getattr(outcome, name) for name in ("blocked", "seconds", "joules")}
        info: dict[str, Any] = {"motion": motion, "_motion": ~fresh}
        if self.autoreset_mode == SAME_STEP:
            over = np.flatnonzero(self._ended())
            if over.size:
                info |= self._final_info(motion, self._rows_of(self._ended()))
                engine.begin(over, [None] * over.size)
        info["motion"] = _flagged(motion, info["_motion"])
        info |= {"action_mask": engine.masks(), "_action_mask": np.ones_like(fresh)}
        return engine.observe(), rewards, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return ``[N, 7]`` int8: 1 for each action that does something now.

        Raises:
            EndedError: before a reset.
        """
        self._check_started("action_masks")
        return self._engine.masks()

    def close(self) -> None:
        """Close the motion backend."""
        self._engine.close()

    def _check_started(self, method: str) -> None:
        if not self._started:
            raise EndedError(f"{method}() needs a reset() before it")

    def _ended(self) -> Flags:
        """Return ``[B]``, whether all robots of each episode have ended."""
        ended = self._engine.ended
        if self._robots == 1:
            return ended
        return np.asarray(ended.reshape(self._episodes, -1).all(axis=1))

    def _rows_of(self, episodes: Flags) -> Flags:
        """Return ``[N]`` flags of rows, given flags of episodes."""
        # Repeating each flag once takes several times as long as copying all.
        return episodes.copy() if self._robots == 1 else np.repeat(episodes, self._robots)

    def _final_info(self, motion: dict[str, NDArray[Any]], ended: Flags) -> dict[str, Any]:
        """Return what info tells about rows ``[N]`` that have ended, before they restart."""
        rows = np.flatnonzero(ended)
        observed: dict[str, Any] = {**self._engine.observe(rows)}
        final_motion = {key: values.copy() for key, values in motion.items()}
        final = {
            "motion": _flagged(final_motion, ended),
            "_motion": ended.copy(),
            "action_mask": self._engine.masks(),
            "_action_mask": ended.copy(),
        }
        return {
            "_motion": ~ended,
            "final_obs": {
                key: _spread(values, rows, len(ended)) for key, values in observed.items()
            },
            "_final_obs": ended.copy(),
            "final_info": final,
            "_final_info": ended.copy(),
        }


def _flagged(motion: dict[str, NDArray[Any]], rows: Flags) -> dict[str, NDArray[Any]]:
    """Return the values of a motion, each with flags of the rows that have one."""
    return motion | {f"_{key}": rows.copy() for key in motion}


def _check_running(ended: Flags) -> None:
    """Raise ``EndedError`` if episodes have ended, in the disabled mode."""
    if ended.any():
        raise EndedError(
            f"{ended.sum()} rows have ended, row {ended.argmax()} first; they must be reset, by a "
            "mask, before the next step"
        )


def _spread(values: NDArray[Any], rows: Integers, count: int) -> NDArray[Any]:
    """Return ``count`` rows that are zero except for those given."""
    spread = np.zeros((count, *values.shape[1:]), values.dtype)
    spread[rows] = values
    return spread
