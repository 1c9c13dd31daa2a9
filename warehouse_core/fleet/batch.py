"""Many fleets at once: ``B`` warehouses with ``R`` robots each, for learning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warehouse_core.arguments import whole_number
from warehouse_core.errors import EndedError
from warehouse_core.fleet.battery import Battery
from warehouse_core.fleet.fleets import make_fleets
from warehouse_core.fleet.observation import FleetArrays
from warehouse_core.fleet.people import People
from warehouse_core.fleet.settings import FleetSettings, as_orders
from warehouse_core.fleet.tally import FleetMeasures
from warehouse_core.motion.backends import Backend
from warehouse_core.motion.vector import Flags
from warehouse_core.orders.order import Orders
from warehouse_core.vector.rows import (
    DISABLED,
    NEXT_STEP,
    SAME_STEP,
    Seeds,
    check_running,
    checked_actions,
    checked_mask,
    checked_mode,
    checked_seeds,
    final_info,
    one_layout_each,
)
from warehouse_core.world.layout import Layout

FleetBatchStep = tuple[FleetArrays, NDArray[np.float64], Flags, Flags, dict[str, Any]]
"""Observation, rewards, terminated, truncated and info."""


class FleetBatch:
    """``B`` fleets of ``R`` robots; row ``b * R + r`` is robot ``r`` of fleet ``b``.

    Description:
        Fleet ``b`` equals a ``FleetEnv`` in its layout with the same seed and actions. A policy
        that is trained on the rows is shared by all robots.

    Actions:
        ``[N]`` integers, 0 to 6: N, E, S, W, WAIT, PICK, DROP; ``N = B * R``.

    Observations:
        ``FleetArrays`` with a leading ``N``.

    Rewards:
        Those of ``FleetEnv``, ``[N]`` float64.

    Ends:
        Those of ``FleetEnv``. A robot that has ended before others of its fleet waits, without a
        reward, and its flags stay set; a fleet of which all robots have ended restarts by
        ``autoreset_mode``.

    Args:
        fleets: ``B``, at least 1.
        layout: one for all fleets, or a list of ``B``; ``None`` is the chapter's.
        robots: ``R``, at least 1; like all that follow, as for ``FleetEnv``.
        autoreset_mode: when a fleet that has ended restarts; see ``BatchEnv``.

    Raises:
        ValueError: a value that is not allowed; also as ``LayoutError``, ``OrderError`` or
            ``BackendError``.
        TypeError: an argument of another type.
    """

    def __init__(
        self,
        fleets: int,
        layout: Layout | Sequence[Layout] | None = None,
        robots: int = 2,
        *,
        backend: Backend = "grid",
        orders: Orders | None = None,
        max_steps: int = 200,
        battery: int | Battery = 200,
        view_radius: int = 2,
        people: int | People = 0,
        dispatch: bool = True,
        late_penalty: float = 0.0,
        team_reward: bool = False,
        autoreset_mode: str = NEXT_STEP,
    ) -> None:
        self.fleets = whole_number("fleets", fleets, 1)
        self.autoreset_mode = checked_mode(autoreset_mode)
        layouts = one_layout_each(layout, fleets)
        self.settings = settings = FleetSettings(
            robots=robots,
            orders=as_orders(orders),
            starts=None,
            max_steps=max_steps,
            battery=battery if isinstance(battery, Battery) else Battery(battery),
            view_radius=view_radius,
            people=people if isinstance(people, People) else People(people),
            dispatch=dispatch,
            late_penalty=late_penalty,
            team_reward=team_reward,
        )
        self.num_envs = fleets * robots
        self.max_steps, self.max_battery = settings.max_steps, settings.battery.capacity
        self.view_radius = settings.view_radius
        self._fleets = make_fleets(layouts, settings, backend)
        self.layouts = self._fleets.layouts
        self._started = False

    @property
    def size(self) -> tuple[int, int]:
        """The largest numbers of rows and of columns of any layout."""
        kinds = self.layouts.kinds
        return max(kind.height for kind in kinds), max(kind.width for kind in kinds)

    def reset(
        self, seed: Seeds = None, mask: Flags | None = None
    ) -> tuple[FleetArrays, dict[str, Any]]:
        """Start an episode in every fleet, or in those of a mask.

        Args:
            seed: fleet ``b`` is reset with ``seed + b``, or with the ``b``-th of ``B`` seeds;
                without one its random numbers continue.
            mask: ``[B]`` bool, the fleets to reset; the others do not change.

        Returns:
            The observation of all rows, and info with the ``action_mask`` of those reset.

        Raises:
            ValueError: a negative seed, or not ``B`` seeds or flags; nothing has changed.
            TypeError: a seed or a flag of another type.
            EndedError: a mask before the first reset.
        """
        seeds = checked_seeds(seed, self.fleets)
        chosen = checked_mask(mask, self.fleets, not self._started)
        floors = np.flatnonzero(chosen)
        self._fleets.reset(floors, [seeds[floor] for floor in floors.tolist()])
        self._started = True
        return self._fleets.observe(), {
            "action_mask": self._fleets.robots.masks(),
            "_action_mask": self._of_robots(chosen),
        }

    def step(self, actions: ArrayLike) -> FleetBatchStep:
        """Carry out one action for each robot.

        Args:
            actions: ``[N]`` integers, 0 to 6.

        Returns:
            Observation, ``[N]`` float64 rewards, ``[N]`` bool terminated and truncated, and info
            as from ``BatchEnv.step``. All arrays are fresh.

        Raises:
            ValueError: a wrong shape, or an action out of range; nothing has changed.
            TypeError: actions that are not integers.
            EndedError: before a reset, or if fleets have ended in the disabled mode.
        """
        if not self._started:
            raise EndedError("step() needs a reset() before it")
        chosen, ended = checked_actions(actions, self.num_envs), self._ended()
        if self.autoreset_mode == DISABLED:
            check_running(ended)
        outcome, rewards, terminated, truncated = self._fleets.step(chosen)
        fresh = self._of_robots(ended)  # their step only starts an episode
        terminated[fresh] = truncated[fresh] = outcome.blocked[fresh] = False
        outcome.seconds[fresh] = outcome.joules[fresh] = 0.0
        motion = {name: getattr(outcome, name) for name in ("blocked", "seconds", "joules")}
        info = {"motion": motion, "_motion": ~fresh}
        if self.autoreset_mode == SAME_STEP:
            ended = self._ended()
            if ended.any():
                rows = self._of_robots(ended)
                observed: dict[str, Any] = {**self._fleets.observe(np.flatnonzero(rows))}
                info |= final_info(info, observed, self._fleets.robots.masks(), rows)
        if ended.any():
            floors = np.flatnonzero(ended)
            self._fleets.reset(floors, [None] * len(floors))
        info |= {"action_mask": self._fleets.robots.masks(), "_action_mask": np.ones_like(fresh)}
        return self._fleets.observe(), rewards, terminated, truncated, info

    def action_masks(self) -> NDArray[np.int8]:
        """Return ``[N, 7]`` int8: 1 for each action that does something now.

        Raises:
            EndedError: before a reset.
        """
        if not self._started:
            raise EndedError("action_masks() needs a reset() before it")
        return self._fleets.robots.masks()

    def measures(self, fleet: int) -> FleetMeasures:
        """Return how well a fleet has done in its present episode."""
        return self._fleets.measures(whole_number("fleet", fleet, 0, self.fleets - 1))

    def close(self) -> None:
        """Close the motion backend."""
        self._fleets.close()

    def _ended(self) -> Flags:
        """Return ``[B]``, whether all robots of each fleet have ended."""
        return np.asarray(self._fleets.ended.reshape(self.fleets, -1).all(axis=1))

    def _of_robots(self, fleets: Flags) -> Flags:
        """Return ``[N]`` flags of robots, given those of fleets."""
        return np.repeat(fleets, self.settings.robots)
