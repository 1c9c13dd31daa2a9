"""``B`` fleets of ``R`` robots as one structure of arrays, stepped together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from warehouse_core.fleet.battery import STEPS
from warehouse_core.fleet.floor import FleetFloor
from warehouse_core.fleet.motion import FleetMotion
from warehouse_core.fleet.observation import FleetArrays
from warehouse_core.fleet.people import Crowd
from warehouse_core.fleet.settings import FleetSettings
from warehouse_core.fleet.starts import FleetStarts
from warehouse_core.fleet.tally import FleetMeasures, Tally
from warehouse_core.fleet.vector_orders import VectorOrders
from warehouse_core.motion.backends import (
    Backend,
    make_fleet_motion,
    make_motion,
)
from warehouse_core.motion.vector import (
    BatchOutcome,
    CanFail,
    Flags,
    FleetBatchMotion,
    Integers,
    Rows,
)
from warehouse_core.task.rules import judge
from warehouse_core.vector.robots import VectorRobots
from warehouse_core.vector.rules import spend_and_charge
from warehouse_core.vector.starts import first_stations
from warehouse_core.world.actions import PICK, WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import LayoutSet
from warehouse_core.world.tiles import EMPTY

ALL = slice(None)

TAKEN = judge(PICK, EMPTY, False, False)
"""The verdict on a robot whose item another one has just taken."""


class FleetStep(NamedTuple):
    """One step of ``N`` robots.

    Attributes:
        outcome: of the motion.
        rewards: ``[N]`` float64.
        terminated: ``[N]`` bool, whether the robot's task is done.
        truncated: ``[N]`` bool, whether its battery or the steps are used up, or it has failed.
    """

    outcome: BatchOutcome
    rewards: NDArray[np.float64]
    terminated: Flags
    truncated: Flags


def make_fleets(layouts: Sequence[Layout], settings: FleetSettings, backend: Backend) -> Fleets:
    """Return fleets on these layouts, moved by a backend.

    Raises:
        BackendError: the backend is unknown, or a single instance for several layouts.
        LayoutError: as for ``Fleets``, as well as ``OrderError``.
    """
    motion = make_fleet_motion(backend, layouts, settings.bodies)
    return Fleets(layouts, settings, motion, make_motion(backend).cell_size)


class Fleets:
    """``B`` fleets, each on a floor of its own; ``N = B * R`` robots, floor by floor.

    Args:
        layouts: ``B``.
        settings: of all fleets.
        motion: of ``R + P`` bodies on each floor, see ``BatchMotion``.
        cell_size: side of a cell in metres, for what a step costs.

    Attributes:
        motion: what moves the robots, and the people among them.
        orders: ``None`` without orders.
        robots: their cells and loads.
        crowd: the people.
        tally: what has been done.
        battery: ``[N]`` float64 units left.
        steps: ``[B]`` taken.
        terminated: ``[N]``, whether the task of the robot is done.
        truncated: ``[N]``, whether its battery or the steps are used up, or it has failed.
        failed: ``[N]``, whether the motion says that it stays where it is for good.

    Raises:
        LayoutError: robots or people that have no room, or stations that are missing.
        OrderError: orders that cannot be carried out.
    """

    def __init__(
        self,
        layouts: Sequence[Layout],
        settings: FleetSettings,
        motion: FleetBatchMotion,
        cell_size: float,
    ) -> None:
        self.layouts, self.settings = LayoutSet(layouts), settings
        floors, rows = len(layouts), len(layouts) * settings.robots
        self._floor = floor = FleetFloor(self.layouts, settings)
        self.orders = VectorOrders(self.layouts, settings, floor) if settings.has_orders else None
        self._starts = [FleetStarts(kind, settings) for kind in self.layouts.kinds]
        self.crowd = Crowd(settings.people, self.layouts)
        if settings.people.count:
            motion = FleetMotion(motion, settings.robots, self.crowd)
        self.motion = motion
        self.robots = VectorRobots(self._floor, motion, rows)
        self.tally = Tally(floors, settings.robots)
        self._streams = [np.random.default_rng() for _ in layouts]
        self._charge = settings.battery.step_charge(cell_size)
        self.battery = np.zeros(rows)
        self.steps = np.zeros(floors, np.int32)
        self.terminated, self.truncated, self.failed = np.zeros((3, rows), np.bool_)
        if not settings.has_orders:
            stations = first_stations(self.layouts.repeated(settings.robots))
            self._floor.put_stations(np.arange(rows), *stations.T)

    @property
    def ended(self) -> Flags:
        """``[N]``, whether the robot has ended: it waits, and stays in the way."""
        return self.terminated | self.truncated

    def reset(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on some floors.

        Args:
            floors: ``[F]``, all different.
            seeds: ``F``; a floor without one continues its stream.
        """
        cells, motion_seeds = [], []
        for floor, seed in zip(floors.tolist(), seeds, strict=True):
            if seed is not None:
                self._streams[floor] = np.random.default_rng(seed)
            starts, orders, people, motion = self._streams[floor].spawn(4)
            robots, persons = self._starts[self.layouts.kind[floor]].draw(starts)
            cells.append(robots)
            self.crowd.enter(floor, persons, people)
            motion_seeds.append(int(motion.integers(2**32)))
            if self.orders:
                self.orders.begin(floor, orders)
        rows = self.rows_of(floors)
        self.robots.place(rows, np.concatenate(cells), motion_seeds)
        self.battery[rows] = self.settings.battery.capacity
        self.terminated[rows] = self.truncated[rows] = self.failed[rows] = False
        self.steps[floors] = 0
        self.tally.clear(floors)
        self._release()

    def step(self, actions: Integers) -> FleetStep:
        """Carry out one action for each robot; those that have ended wait.

        Args:
            actions: ``[N]`` intp, 0 to 6.
        """
        active, had_item = ~self.ended, self.robots.has_item
        chosen = np.where(active, actions, WAIT)
        outcome, rewards, delivered, charging = self.robots.step(chosen)
        charging = np.zeros_like(active) if charging is None else charging & active
        rewards[~active] = 0.0
        self.steps += 1
        if self.orders:
            self._book(self.orders, had_item, delivered, rewards)
        self._use_batteries(outcome, charging, active)
        if outcome.failed is not None:
            self.failed = outcome.failed.copy()
        self.tally.add(chosen, outcome, charging, delivered, active)
        self._release()
        self._end(delivered)
        if self.settings.team_reward:
            teams = rewards.reshape(-1, self.settings.robots)
            teams[:] = teams.mean(axis=1, keepdims=True)
        return FleetStep(outcome, rewards, self.terminated.copy(), self.truncated.copy())

    def observe(self, rows: Rows = ALL) -> FleetArrays:
        """Return fresh arrays of what some of the robots observe."""
        self._floor.show(self.robots.cells, self.robots.has_item, self.crowd.cells)
        steps = np.repeat(self.steps, self.settings.robots)[rows]
        battery = np.floor(self.battery[rows]).astype(np.int32)
        arrays = self.robots.observe(rows, battery[:, None], steps[:, None])
        found = cast(FleetArrays, arrays)
        if self.orders:
            found["due"] = self.orders.due[rows, None].copy()
        if self._floor.has_chargers:
            found["charger_pos"] = self._floor.nearest_chargers(rows, self.robots.cells[rows])
        return found

    def measures(self, floor: int) -> FleetMeasures:
        """Return the measures of the present episode on a floor."""
        rows = self.rows_of(np.array([floor]))
        book = self.orders.books[floor] if self.orders else None
        found = self.tally.measures(floor, int(self.steps[floor]), book.records() if book else None)
        stranded = int(self._is_out[rows].sum())
        return replace(found, stranded=stranded, lost=book.lost if book else 0)

    def rows_of(self, floors: Integers) -> NDArray[np.intp]:
        """Return the rows of all robots on some floors."""
        robots = self.settings.robots
        return (floors[:, None] * robots + np.arange(robots)).ravel()

    def close(self) -> None:
        """Close the motion backend."""
        self.motion.close()

    def _book(
        self,
        orders: VectorOrders,
        had_item: Flags,
        delivered: Flags,
        rewards: NDArray[np.float64],
    ) -> None:
        """Book picks and deliveries, in the order of the robots."""
        has_item, robots = self.robots.has_item, self.settings.robots
        for row in np.flatnonzero(has_item & ~had_item).tolist():
            step = int(self.steps[row // robots])
            if not orders.take(row, int(self.robots.cells[row]), step):
                has_item[row], rewards[row] = False, TAKEN.reward
        for row in np.flatnonzero(delivered).tolist():
            late = orders.deliver(row, int(self.steps[row // robots]))
            rewards[row] -= self.settings.late_penalty * late

    def _use_batteries(self, outcome: BatchOutcome, charging: Flags, active: Flags) -> None:
        battery = self.settings.battery
        cost = np.where(active, 1.0 if battery.unit == STEPS else outcome.joules, 0.0)
        spend_and_charge(self.battery, battery.capacity, charging, cost, self._charge)
        np.maximum(self.battery, 0.0, out=self.battery)  # the last step may cost more than is left

    def _release(self) -> None:
        """Give back what stranded robots were to take, and let orders appear."""
        if self.orders:
            active, is_out = ~self.ended, self._is_out
            if is_out.any():
                self.orders.strand(np.flatnonzero(active & is_out))
            self.orders.release(self.steps, self.robots.cells, active & ~is_out)

    def _end(self, delivered: Flags) -> None:
        """Set which robots have ended."""
        active, robots = ~self.ended, self.settings.robots
        done = np.repeat(self.orders.all_delivered(), robots) if self.orders else delivered
        is_over = np.repeat(self.steps >= self.settings.max_steps, robots)
        self.terminated |= active & done
        empty = np.flatnonzero(active & (self.battery <= 0) & ~self.failed)
        if len(empty) and isinstance(self.motion, CanFail):
            self.motion.fail(empty)
        self.truncated |= active & (self._is_out | is_over)

    @property
    def _is_out(self) -> Flags:
        """Whether the battery of each robot is empty, or it has failed, ``[N]``."""
        found: Flags = (self.battery <= 0) | self.failed
        return found
