"""``B`` lone robots, each on a floor of its own, as one structure of arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from warehouse_core.batch.lone.draws import EpisodeDraws
from warehouse_core.batch.shell.env import NO_FLOORS, EngineStep
from warehouse_core.batch.shell.floor import ALL, Floor
from warehouse_core.batch.shell.robots import Robots
from warehouse_core.batch.shell.verdicts import spend_and_charge
from warehouse_core.motion.base import BaseBatchMotion
from warehouse_core.task.encoding import ObservationArrays
from warehouse_core.task.state import WarehouseState
from warehouse_core.world.actions import WAIT
from warehouse_core.world.layout import Layout
from warehouse_core.world.tables import Integers, LayoutSet, Rows


class LoneEngine:
    """The episodes of ``B`` lone robots; see ``Engine``."""

    def __init__(
        self,
        layouts: LayoutSet,
        draws: EpisodeDraws,
        floor: Floor,
        motion: BaseBatchMotion,
        max_steps: int,
        battery: int,
    ) -> None:
        count = len(layouts.kind)
        self.layouts, self.draws, self._floor, self._motion = layouts, draws, floor, motion
        self._robots = Robots(floor, motion, count)
        self._max_steps, self._max_battery = max_steps, battery
        self._steps = np.zeros(count, np.int32)
        self.ended = np.zeros(count, np.bool_)
        # Without chargers the battery follows from the steps, and needs no array.
        self._battery = np.zeros(count, np.int32) if floor.has_chargers else None
        self._last_step = min(max_steps, battery)

    def begin(self, floors: Integers, seeds: Sequence[int | None]) -> None:
        """Start an episode on some floors; see ``Engine.begin``."""
        self.draws.seed(floors, seeds)
        if self.layouts.others:
            self._motion.change(floors, self.draws.draw_layouts(floors))
        stations, starts = self.draws.draw(floors)
        if stations is None:
            self._floor.put_own_stations(floors)
        else:
            self._floor.put_stations(floors, *stations)
        self._robots.place(floors, starts)
        self.ended[floors], self._steps[floors] = False, 0
        if self._battery is not None:
            self._battery[floors] = self._max_battery

    def step(self, actions: NDArray[np.intp], over: Integers = NO_FLOORS) -> EngineStep:
        """Carry out one action for each robot; see ``Engine.step``."""
        if over.size:
            self.begin(over, [None] * over.size)
            actions[over] = WAIT
        outcome, rewards, terminated, charging = self._robots.step(actions)
        rewards[over] = 0.0
        self._steps += 1
        self._steps[over] = 0
        if self._battery is None or charging is None:
            truncated = self._steps >= self._last_step
        else:
            spend_and_charge(self._battery, self._max_battery, charging)
            self._battery[over] = self._max_battery
            truncated = (self._steps >= self._max_steps) | (self._battery <= 0)
        self.ended = terminated | truncated
        return EngineStep(outcome, rewards, terminated, truncated)

    def observe(self, rows: Rows = ALL) -> ObservationArrays:
        """Return fresh arrays of what some of the robots observe."""
        steps = self._steps[rows][:, None]
        return self._robots.observe(rows, self._units(rows)[:, None], steps.copy())

    def masks(self) -> NDArray[np.int8]:
        """Return ``[B, 7]`` int8: 1 for each action that does something now."""
        return self._robots.masks()

    def state(self, row: int) -> tuple[Layout, WarehouseState]:
        """Return the layout of a row, with its stations, and the state of its robot."""
        layout, robots = self.layouts.kinds[self.layouts.kind[row]], self._robots
        if self._floor.moving_stations:
            layout = layout.with_stations(*map(tuple, self._floor.station_places[:, row].tolist()))
        cell, has_item = layout.cell(robots.cells[row]), bool(robots.has_item[row])
        battery, steps = int(self._units(np.array([row]))[0]), int(self._steps[row])
        return layout, WarehouseState(cell, has_item, battery, steps)

    def close(self) -> None:
        """Close the motion backend."""
        self._motion.close()

    def _units(self, rows: Rows) -> NDArray[np.int32]:
        """Return the battery units of some rows, a new array."""
        if self._battery is None:
            return self._max_battery - self._steps[rows]
        return self._battery[rows].copy()
