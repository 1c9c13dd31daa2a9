"""Environments with many parallel episodes in arrays: checks, resets, steps and restarts.

A *row* is a robot. The engine implements a step. ``ArrayEnv``, which is the same for single robots
and for fleets, decides when episodes start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import MAX_SEED, one_of, seed_number, sequence_of, whole_number
from warehouse_core.batch.floor import ALL
from warehouse_core.errors import EndedError, LayoutError
from warehouse_core.listing import Unlisted
from warehouse_core.motion.base import BatchOutcome
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.wording import brief
from warehouse_core.world.actions import ACTIONS
from warehouse_core.world.layout import DEFAULT_LAYOUT, Layout
from warehouse_core.world.tables import Flags, Integers, LayoutSet, Rows

Seeds = int | Sequence[int | None] | None


def checked_actions(actions: ArrayLike, rows: int, count: int) -> NDArray[np.intp]:
    """Return a checked copy of the actions ``[rows]``, each of them less than ``count``."""
    try:
        given = np.asarray(actions)
    except Exception:  # rows of different lengths, or a user's ``__array__``
        raise TypeError(f"the actions are {brief(actions)}; they must be integers") from None
    if given.dtype.kind not in "iu":
        raise TypeError(f"the actions are {given.dtype}; they must be integers")
    if given.shape != (rows,):
        raise ValueError(f"the actions have the shape {given.shape}; it must be ({rows},)")
    chosen = given.astype(np.intp)
    # Negative numbers are very large as unsigned numbers.
    if chosen.view(np.uintp).max() >= count:
        row = int(np.argmax(chosen.view(np.uintp) >= count))
        raise ValueError(f"the action of row {row} is {given[row]}; allowed: 0..{count - 1}")
    return chosen


def checked_mask(mask: Flags | None, rows: int, is_first: bool) -> Flags:
    """Return a checked copy of the mask of rows to reset; ``None`` stands for all rows."""
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
    """Return a layout for each row, given one layout, a layout per row, or ``None``."""
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
    """Raise an error if layouts cannot form a pool, or other arguments exclude a pool."""
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
    """Return a seed for each row, given one per row, the first of consecutive ones, or ``None``."""
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
"""Modes in which a batch restarts episodes, with their names in Gymnasium."""

NO_FLOORS = np.empty(0, np.intp)

Observed = TypeVar("Observed", bound=ObservationArrays, covariant=True)


class EngineStep(NamedTuple):
    """One step of ``N`` rows, as arrays ``[N]`` that belong to the caller."""

    outcome: BatchOutcome
    rewards: NDArray[np.float64]
    terminated: Flags
    truncated: Flags


class Engine(Protocol[Observed]):
    """``B`` floors with an episode on each, and ``N`` rows in all, as many on each floor."""

    layouts: LayoutSet

    @property
    def ended(self) -> Flags:
        """Flags ``[N]`` of robots that have ended. They wait, block others, and get no reward."""

    def begin(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on some floors; those without a seed continue their random streams."""

    def step(self, actions: NDArray[np.intp], over: Integers = NO_FLOORS) -> EngineStep:
        """Carry out one action, 0 to 6, for each robot; the array may be changed.

        On the floors in ``over``, start an episode instead.
        """

    def observe(self, rows: Rows = ALL) -> Observed:
        """Return the observations of some robots, as new arrays."""

    def masks(self) -> NDArray[np.int8]:
        """Return the masks ``[N, 7]`` int8: 1 for each action with an effect."""

    def close(self) -> None:
        """Close the motion backend."""


class ArrayEnv(Unlisted, Generic[Observed]):
    """A batch of ``B`` episodes of ``R`` robots; row ``b * R + r`` is robot ``r`` of episode ``b``.

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
        """The largest height and the largest width of the layouts."""
        kinds = self.layouts.kinds
        return max(kind.height for kind in kinds), max(kind.width for kind in kinds)

    def reset(
        self, seed: Seeds = None, mask: Flags | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Start all episodes, or those in a mask.

        Nothing changes if an error is raised.

        Args:
            seed: seed of episode 0, where episode ``b`` has the seed ``seed + b``; or a seed for
                each of the ``B`` episodes. Episodes without a seed continue their random streams.
            mask: ``[B]`` flags of the episodes to reset; ``None`` for all.

        Returns:
            The observation of all rows, and info with the ``action_mask`` of the rows that have
            been reset.

        Raises:
            ValueError: a seed is negative, or there are not ``B`` seeds or flags.
            TypeError: a seed or a flag has the wrong type.
            EndedError: the first reset has a mask.
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
            actions: ``[N]`` integers, 0 to 6, or indices of the actions of a fleet.

        Returns:
            Observations, ``[N]`` float64 rewards, ``[N]`` bool terminated and truncated, and info.
            Info has ``action_mask`` ``[N, 7]`` int8, and ``motion`` with ``blocked``, ``seconds``
            and ``joules``. In the same-step mode it also has ``final_obs`` and ``final_info`` of
            episodes that have ended. Each key ``k``, also within ``motion``, comes with a key
            ``_k``, the flags ``[N]`` of the rows to which it applies. All arrays are new.

        Raises:
            ValueError: the shape is wrong, or an action is out of range; nothing has changed.
            TypeError: the actions are not integers.
            EndedError: there has been no reset, or episodes have ended in the disabled mode.
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
        """Return the masks ``[N, 7]`` int8: 1 for each action with an effect.

        Raises:
            EndedError: there has been no reset.
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
        """Return the flags ``[B]`` of episodes whose robots have all ended."""
        ended = self._engine.ended
        if self._robots == 1:
            return ended
        return np.asarray(ended.reshape(self._episodes, -1).all(axis=1))

    def _rows_of(self, episodes: Flags) -> Flags:
        """Return the flags ``[N]`` of rows, given the flags of episodes."""
        # Copying is several times as fast as repeating each flag once.
        return episodes.copy() if self._robots == 1 else np.repeat(episodes, self._robots)

    def _final_info(self, motion: dict[str, NDArray[Any]], ended: Flags) -> dict[str, Any]:
        """Return the entries of info about ended rows ``[N]``, before they restart."""
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
    """Return the values of a motion, each with flags of the rows to which it applies."""
    return motion | {f"_{key}": rows.copy() for key in motion}


def _check_running(ended: Flags) -> None:
    """Raise ``EndedError`` if episodes have ended, which the disabled mode does not restart."""
    if ended.any():
        raise EndedError(
            f"{ended.sum()} rows have ended, row {ended.argmax()} first; they must be reset with a "
            "mask before the next step"
        )


def _spread(values: NDArray[Any], rows: Integers, count: int) -> NDArray[Any]:
    """Return an array of ``count`` rows that has ``values`` in ``rows`` and zeros elsewhere."""
    spread = np.zeros((count, *values.shape[1:]), values.dtype)
    spread[rows] = values
    return spread
