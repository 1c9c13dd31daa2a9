"""Many warehouses at once: ``B`` environments stepped together by NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.errors import BackendError, EndedError
from warehouse_core.motion.backends import Backend, make_batch_motion
from warehouse_core.motion.vector import ChangesLayouts, Flags, Integers, Rows
from warehouse_core.task.encoding import MAX_STEPS, Arrays
from warehouse_core.task.starts import what_is_drawn
from warehouse_core.task.state import WarehouseState
from warehouse_core.vector.floor import VectorFloor
from warehouse_core.vector.robots import VectorRobots
from warehouse_core.vector.rows import (
    DISABLED,
    NEXT_STEP,
    SAME_STEP,
    Seeds,
    check_pool,
    check_running,
    checked_actions,
    checked_mask,
    checked_mode,
    checked_seeds,
    final_info,
    one_layout_each,
)
from warehouse_core.vector.rules import spend_and_charge
from warehouse_core.vector.starts import VectorStarts
from warehouse_core.world.actions import WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import Cell

ALL = slice(None)

BatchStep = tuple[Arrays, NDArray[np.float64], Flags, Flags, dict[str, Any]]
"""Observation, rewards, terminated, truncated and info."""


class BatchEnv:
    """``B`` warehouses with one robot each.

    Description:
        Row ``b`` equals a ``WarehouseEnv`` in its layout with the same actions: the rules are
        those of ``task/rules.py``, and the moves those of the same backends.

    Actions:
        ``[B]`` integers, 0 to 6: N, E, S, W, WAIT, PICK, DROP.

    Observations:
        The ``Arrays`` of ``task/encoding.py`` with a leading ``B``.

    Rewards:
        The table in ``task/rules.py``, ``[B]`` float64.

    Ends:
        Terminated by the delivery; truncated when the steps or the battery are used up. Rows that
        have ended restart by ``autoreset_mode``.

    Args:
        num_envs: ``B``, at least 1.
        layout: one for all rows, or a list of ``B``; ``None`` is the chapter's.
        start_pos: start of robots that is not drawn, one for all rows or, without a pool, ``B`` of
            them; ``None`` is the usual start of each layout.
        max_steps: limit of an episode, 1 to ``MAX_STEPS``.
        battery: units of a full charge, 1 to ``MAX_STEPS``; every step costs one, and waiting on
            a charger charges.
        view_radius: cells seen in each direction; with 0 a robot sees only itself.
        randomize: what is drawn for each episode: ``True`` for pickup, dropoff and start, or
            ``"stations"`` or ``"start"`` for one of the two.
        autoreset_mode: when a row that has ended restarts: in the next step, which takes no action
            (``"NextStep"``), in the same step (``"SameStep"``), or only in a ``reset`` with a mask
            (``"Disabled"``).
        backend: name, class or instance of a motion with a method ``batch``.
        pool: layouts of one size, instead of ``layout``. For each episode a row draws one of them,
            from its stream and before its start.
        marked: the tiles of ``encoding.vector``: ``local_grid`` is then their ``marks``, of which
            it makes vectors several times as fast as of codes; by default, and on very large
            floors, it is codes.

    Raises:
        ValueError: a value that is not allowed; also as ``LayoutError`` or ``BackendError``.
        TypeError: an argument of another type.
    """

    def __init__(
        self,
        num_envs: int,
        layout: Layout | Sequence[Layout] | None = None,
        start_pos: Cell | Sequence[Cell] | None = None,
        max_steps: int = 200,
        battery: int = 200,
        view_radius: int = 2,
        *,
        randomize: bool | str = True,
        autoreset_mode: str = NEXT_STEP,
        backend: Backend = "grid",
        pool: Sequence[Layout] | None = None,
        marked: tuple[str, ...] = (),
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs, minimum=1)
        self.max_steps = whole_number("max_steps", max_steps, 1, MAX_STEPS)
        self.max_battery = whole_number("battery", battery, 1, MAX_STEPS)
        self.view_radius = whole_number("view_radius", view_radius, minimum=0)
        self.autoreset_mode, self.randomize = checked_mode(autoreset_mode), randomize
        self._drawn = drawn = what_is_drawn(randomize)
        if pool is None:
            self.layouts = LayoutSet(one_layout_each(layout, self.num_envs))
        else:
            check_pool(pool, layout, start_pos)
            self.layouts = LayoutSet([pool[0]] * self.num_envs, pool)
        if drawn.stations:
            self.layouts = self.layouts.without_stations()
        self._start = VectorStarts(self.layouts, start_pos, drawn)
        self._floor = VectorFloor(
            self.layouts, self.view_radius, moving_stations=drawn.stations, tiles=marked
        )
        motion = make_batch_motion(backend, self.layouts.rows)
        if pool is not None and not isinstance(motion, ChangesLayouts):
            raise BackendError(
                f"backend {backend!r} cannot change layouts, which a pool needs; its batch would "
                "need a method change(floors, layouts)"
            )
        self._robots = VectorRobots(self._floor, motion, self.num_envs)
        self._steps = np.zeros(self.num_envs, np.int32)
        self._ended = np.zeros(self.num_envs, np.bool_)
        self._started = False
        # Without chargers the battery follows from the steps, and needs no array.
        self._battery = np.zeros(self.num_envs, np.int32) if self._floor.has_chargers else None
        self._last_step = min(self.max_steps, self.max_battery)

    @property
    def size(self) -> tuple[int, int]:
        """The largest numbers of rows and of columns of any layout."""
        kinds = self.layouts.kinds
        return max(kind.height for kind in kinds), max(kind.width for kind in kinds)

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each row, which is random if none was given."""
        return tuple(map(self._start.seed_of, range(self.num_envs)))

    @property
    def streams(self) -> tuple[np.random.Generator, ...]:
        """The random stream of each row, from which ``reset`` draws its starts."""
        return tuple(map(self._start.stream, range(self.num_envs)))

    def reset(self, seed: Seeds = None, mask: Flags | None = None) -> tuple[Arrays, dict[str, Any]]:
        """Start an episode in every row, or in those of a mask.

        Args:
            seed: row ``b`` draws its starts from ``default_rng(seed + b)``, or from the ``b``-th
                of ``B`` seeds; without one it continues its stream.
            mask: ``[B]`` bool, the rows to reset; the others do not change.

        Returns:
            The observation of all rows, and info with the ``action_mask`` of those reset.

        Raises:
            ValueError: a negative seed, or not ``B`` seeds or flags; nothing has changed.
            TypeError: a seed or a flag of another type.
            EndedError: a mask before the first reset.
        """
        seeds = checked_seeds(seed, self.num_envs)
        chosen = checked_mask(mask, self.num_envs, not self._started)
        rows = np.flatnonzero(chosen)
        self._start.seed(rows, [seeds[row] for row in rows.tolist()])
        self._begin(rows)
        self._started = True
        return self._observe(ALL), {"action_mask": self._robots.masks(), "_action_mask": chosen}

    def step(self, actions: ArrayLike) -> BatchStep:
        """Carry out one action in each row.

        Args:
            actions: ``[B]`` integers, 0 to 6.

        Returns:
            Observation, ``[B]`` float64 rewards, ``[B]`` bool terminated and truncated, and info:
            ``action_mask`` ``[B, 7]`` int8; ``motion`` with ``blocked``, ``seconds`` and
            ``joules``; and, in the same-step mode if rows have ended, their ``final_obs`` and
            ``final_info``. Each key ``k`` has a key ``_k``, ``[B]`` bool: the rows that it applies
            to. All arrays are fresh.

        Raises:
            ValueError: a wrong shape, or an action out of range; nothing has changed.
            TypeError: actions that are not integers.
            EndedError: before a reset, or if rows have ended in the disabled mode.
        """
        if not self._started:
            raise EndedError("step() needs a reset() before it")
        chosen = checked_actions(actions, self.num_envs)
        fresh = self._restart_ended()
        chosen[fresh] = WAIT  # their step only starts an episode
        outcome, rewards, terminated, charging = self._robots.step(chosen)
        self._steps += 1
        self._steps[fresh] = 0
        truncated = self._truncated(charging, fresh)
        rewards[fresh] = outcome.seconds[fresh] = outcome.joules[fresh] = 0.0
        self._ended = terminated | truncated
        moved = np.ones_like(terminated)
        moved[fresh] = False
        motion = {name: getattr(outcome, name) for name in ("blocked", "seconds", "joules")}
        info = {"motion": motion, "_motion": moved}
        if self.autoreset_mode == SAME_STEP and self._ended.any():
            self._end_episodes(info)
        info |= {"action_mask": self._robots.masks(), "_action_mask": np.ones_like(terminated)}
        return self._observe(ALL), rewards, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return ``[B, 7]`` int8: 1 for each action that does something now.

        Raises:
            EndedError: before a reset.
        """
        if not self._started:
            raise EndedError("action_masks() needs a reset() before it")
        return self._robots.masks()

    def row(self, row: int) -> tuple[Layout, WarehouseState]:
        """Return the layout and the state of one row.

        Raises:
            EndedError: before a reset.
        """
        if not self._started:
            raise EndedError("row() needs a reset() before it")
        layout = self.layouts.kinds[self.layouts.kind[row]]
        if self._drawn.stations:
            layout = layout.with_stations(*map(tuple, self._floor.station_places[:, row].tolist()))
        robot, steps = divmod(int(self._robots.cells[row]), layout.width), int(self._steps[row])
        has_item, battery = bool(self._robots.has_item[row]), int(self._units(np.array([row]))[0])
        return layout, WarehouseState(robot, has_item, battery, steps)

    def close(self) -> None:
        """Close the motion backend."""
        self._robots.motion.close()

    def _truncated(self, charging: Flags | None, fresh: Integers) -> Flags:
        """Use and charge the batteries; return which rows are truncated, see ``is_truncated``."""
        if self._battery is None or charging is None:
            return self._steps >= self._last_step
        spend_and_charge(self._battery, self.max_battery, charging)
        self._battery[fresh] = self.max_battery
        return (self._steps >= self.max_steps) | (self._battery <= 0)

    def _units(self, rows: Rows) -> NDArray[np.int32]:
        """Return the battery units of some rows, a new array."""
        if self._battery is None:
            return self.max_battery - self._steps[rows]
        return self._battery[rows].copy()

    def _begin(self, rows: Integers) -> None:
        """Start an episode in some rows."""
        motion = self._robots.motion
        if self.layouts.others and isinstance(motion, ChangesLayouts):
            motion.change(rows, self._start.draw_layouts(rows))
        pickups, dropoffs, robots = self._start.draw(rows)
        self._floor.put_stations(rows, pickups, dropoffs)
        self._robots.place(rows, robots)
        self._ended[rows], self._steps[rows] = False, 0
        if self._battery is not None:
            self._battery[rows] = self.max_battery

    def _restart_ended(self) -> Integers:
        """Restart the rows that have ended, in the next-step mode, and return their numbers."""
        if self.autoreset_mode == DISABLED:
            check_running(self._ended)
        rows = np.flatnonzero(self._ended)
        if rows.size:
            self._begin(rows)
        return rows

    def _end_episodes(self, info: dict[str, Any]) -> None:
        """Restart the rows that have ended, and add their final observations to info."""
        rows = np.flatnonzero(self._ended)
        final = final_info(info, {**self._observe(rows)}, self._robots.masks(), self._ended.copy())
        self._begin(rows)
        info |= final

    def _observe(self, rows: Rows) -> Arrays:
        steps = self._steps[rows][:, None]
        return self._robots.observe(rows, self._units(rows)[:, None], steps.copy())
