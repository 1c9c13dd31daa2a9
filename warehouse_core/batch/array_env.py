"""Environments in arrays: how episodes side by side are checked, reset, stepped and restarted.

A *row* is a robot. The engine knows what happens in a step; ``ArrayEnv``, which is the same for
lone robots and for fleets, knows when episodes start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import MAX_SEED, one_of, seed_number, sequence_of, whole_number
from warehouse_core.batch.floor import ALL
from warehouse_core.copies import CopiedWhole
from warehouse_core.errors import EndedError, LayoutError
from warehouse_core.motion.base import BatchOutcome
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.tables import Flags, Integers, LayoutSet, Rows

Seeds = int | Sequence[int | None] | None


def checked_actions(actions: ArrayLike, rows: int, count: int) -> NDArray[np.intp]:
    """Return a checked copy of the actions, each of which is one of ``count``."""
    try:
        given = np.asarray(actions)
    except Exception:  # rows of different lengths, or a user's ``__array__``
        raise TypeError(f"the actions are {brief(actions)}; they must be integers") from None
    if given.dtype.kind not in "iu":
        raise TypeError(f"the actions are {given.dtype}; they must be integers")
    if given.shape != (rows,):
        raise ValueError(f"the actions have the shape {given.shape}; it must be ({rows},)")
    chosen = given.astype(np.intp)
    # As unsigned numbers, negative ones are very large.
    if chosen.view(np.uintp).max() >= count:
        row = int(np.argmax(chosen.view(np.uintp) >= count))
        raise ValueError(f"the action of row {row} is {given[row]}; allowed: 0..{count - 1}")
    return chosen


def checked_mask(mask: Flags | None, rows: int, is_first: bool) -> Flags:
    """Return a checked copy of the mask of rows to reset; ``None`` is all of them."""
    if mask is None:
        return np.ones(rows, np.bool_)
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
        raise TypeError(f"the mask is {brief(mask)}; it must be an array of bool")
    if mask.shape != (rows,) or not mask.any():
        raise ValueError(
            f"the mask has the shape {mask.shape} and {mask.sum()} rows set; "
            f"the shape must be ({rows},) and at least one row set"
        )
    if is_first:
        raise EndedError("the first reset() must be of all rows, without a mask")
    return mask.copy()


def one_layout_each(layout: Layout | Sequence[Layout] | None, rows: int) -> Sequence[Layout]:
    """Return a layout for each row, given one for all or one each; ``None`` is the chapter's."""
    if layout is None or isinstance(layout, Layout):
        return [layout or DEFAULT_LAYOUT] * rows
    if not isinstance(layout, Sequence):
        raise TypeError(f"layout is {brief(layout)}; it must be a Layout, or one for each row")
    if len(layout) != rows:
        raise ValueError(f"{len(layout)} layouts for {rows} rows; give one, or one for each row")
    for row, each in enumerate(layout):
        if not isinstance(each, Layout):
            raise TypeError(f"the layout of row {row} is {type(each).__name__}, not a Layout")
    return layout


def check_pool(pool: Sequence[Layout], layout: object, start_pos: Any) -> None:
    """Raise if layouts cannot be a pool, or other arguments cannot be given with one."""
    if layout is not None:
        raise ValueError("layout and pool are both given; allowed: one of them")
    if not sequence_of("pool", pool, Layout):
        raise ValueError("pool is empty; it needs at least one layout")
    if start_pos is not None and np.shape(start_pos) != (2,):
        raise ValueError(f"start_pos is {brief(start_pos)}; with a pool it must be one cell")
    height, width = pool[0].height, pool[0].width
    for number, each in enumerate(pool):
        if (each.height, each.width) != (height, width):
            raise LayoutError(
                f"layout {number} of the pool is {each.height} x {each.width} and layout 0 "
                f"{height} x {width}; all must have one size"
            )


def checked_seeds(seed: Seeds, rows: int) -> Sequence[int | None]:
    """Return a seed for each row: one each, consecutive ones from a first, or ``None``."""
    if seed is None:
        return [None] * rows
    if isinstance(seed, (int, np.integer)):
        first = whole_number("seed", seed, 0, MAX_SEED)
        return range(first, first + rows)
    is_array = isinstance(seed, np.ndarray) and seed.ndim == 1
    if not is_array and (not isinstance(seed, Sequence) or isinstance(seed, (str, bytes))):
        raise TypeError(f"seed is {brief(seed)}; it must be an integer or one for each row")
    if len(seed) != rows:
        raise ValueError(f"{len(seed)} seeds for {rows} rows; give one, or one for each row")
    return [seed_number(each, f"the seed of row {row}") for row, each in enumerate(seed)]


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
